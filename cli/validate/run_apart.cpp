// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/run_apart.cpp
#include "validate/run_apart.h"

#include <fmt/format.h>
#include <poll.h>
#include <string.h>
#include <sys/mman.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <list>
#include <new>
#include <type_traits>

#include "model/codes.h"
#include "process/byte_stream.h"
#include "process/child_process.h"
#include "process/exr_apart.h"
#include "process/hdf5_apart.h"
#include "process/worker_io.h"

namespace dgm::validate {
namespace {
namespace codes = model::codes;
using Clock = std::chrono::steady_clock;

constexpr std::string_view kBegin = "begin ", kEnd = "end ";
constexpr std::size_t kMostBytes = std::size_t{1} << 30;

/// The number of the next file, which all copies count up.
class SharedCounter {
 public:
    SharedCounter() {
        void* memory = mmap(nullptr, sizeof(Number), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED) throw model::Error(codes::kSystemBusy, "no memory for a counter");
        number_ = new (memory) Number(0);
    }
    SharedCounter(const SharedCounter&) = delete;
    SharedCounter& operator=(const SharedCounter&) = delete;
    ~SharedCounter() { munmap(number_, sizeof(Number)); }
    std::size_t take() { return (*number_)++; }
    [[nodiscard]] std::size_t taken() const { return *number_; }

 private:
    using Number = std::atomic<std::size_t>;
    static_assert(Number::is_always_lock_free);
    Number* number_;
};

template <class T>
void put_optional(bake::ByteWriter& out, const std::optional<T>& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    out.put(static_cast<char>(value.has_value()));
    out.put(value.value_or(T{}));
}

template <class T>
void get_optional(bake::ByteReader& in, std::optional<T>& value) {
    const bool is_there = in.get<char>() != 0;
    const T read = in.get<T>();
    if (is_there) value = read;
}

FileValidation failed(const std::filesystem::path& path, const model::Code& code, std::string message) {
    FileValidation out;
    out.path = path;
    out.findings.push_back({&code, formats::Severity::kError, std::move(message), {}, {}, {}});
    return out;
}

std::string memory_text(const FileLimits& limits) {
    return fmt::format("its checks need more than the {} MiB they may take", limits.memory_bytes >> 20);
}

/// One copy of the program, and the file that it is at.
struct Slot {
    bake::ChildProcess child;
    std::optional<std::size_t> file;
    Clock::time_point started = Clock::now();
    bool is_short = false;   ///< an allocation failed
    bool has_begun = false;  ///< with any file
};

class ApartRun {
 public:
    ApartRun(std::size_t count, unsigned jobs, const FileLimits& limits,
             const std::function<FileValidation(std::size_t)>& validate,
             const std::function<std::filesystem::path(std::size_t)>& name,
             const std::function<void(std::size_t, FileValidation&)>& done)
        : limits_(limits), validate_(validate), name_(name), done_(done), jobs_(jobs), results_(count) {}

    std::vector<FileValidation> run() {
        while (told_ < results_.size()) {
            while (slots_.size() < std::max(jobs_, 1U) && next_.taken() < results_.size() && begin()) {}
            wait();
            for (auto slot = slots_.begin(); slot != slots_.end();)
                slot = is_through(*slot) ? slots_.erase(slot) : std::next(slot);
            // A copy that ended between taking a number and saying so has told of no file.
            if (slots_.empty() && next_.taken() >= results_.size()) judge_forgotten();
            for (; told_ < results_.size() && results_[told_]; ++told_) done_(told_, *results_[told_]);
        }
        std::vector<FileValidation> out;
        for (std::optional<FileValidation>& result : results_) out.push_back(std::move(*result));
        return out;
    }

 private:
    /// False if the system has no process left, and others can go on.
    bool begin() {
        try {
            slots_.push_back({bake::ChildProcess(std::function<void()>([this] { work(); })), {}});
            return true;
        } catch (const model::Error&) {
            if (slots_.empty()) throw;
            return false;
        }
    }

    /// In the copy.
    void work() {
        const bake::Hdf5Apart hdf5;
        const bake::ExrApart exr;
        bake::limit_worker_memory(limits_.memory_bytes, limits_.threads);
        const tbb::global_control threads(tbb::global_control::max_allowed_parallelism, std::max(1U, limits_.threads));
        for (std::size_t k = next_.take(); k < results_.size(); k = next_.take()) {
            if (!bake::send_message(fmt::format("{}{}\n", kBegin, k))) return;
            FileValidation result;
            try {
                result = validate_(k);
            } catch (const std::bad_alloc&) { return; }  // told already; a fresh copy takes the next file
            if (!bake::send_message(fmt::format("{}{}\n", kEnd, encode_result(result)))) return;
        }
    }

    void wait() const {
        std::vector<pollfd> descriptors;
        for (const Slot& slot : slots_)
            for (const int fd : {slot.child.messages(), slot.child.errors()})
                if (fd >= 0) descriptors.push_back({fd, POLLIN, 0});
        constexpr int kTick = 200, kEndTick = 2;
        poll(descriptors.data(), descriptors.size(), descriptors.empty() ? kEndTick : kTick);
    }

    bool is_through(Slot& slot) {
        slot.child.read_errors();
        std::vector<std::string> lines;
        bool sane = slot.child.read_messages(lines, kMostBytes);
        for (const std::string& line : lines) sane = sane && take(slot, line);
        const std::chrono::duration<double> taken = Clock::now() - slot.started;
        if (!sane) return give_up(slot, codes::kWorkerCrashed, "its checks sent something that is no result");
        if (slot.file && taken.count() > limits_.seconds)
            return give_up(slot, codes::kWorkerTimeout, fmt::format("not done after {} s", limits_.seconds));
        if (slot.child.messages() >= 0 || slot.child.errors() >= 0) return false;
        const std::optional<bake::ChildEnd> end = slot.child.poll_end();
        if (!end) return false;
        if (!slot.has_begun) count_stillborn(*end);
        if (slot.is_short) return give_up(slot, codes::kWorkerMemory, memory_text(limits_));
        return give_up(slot, codes::kWorkerCrashed,
                       end->signal != 0
                           ? fmt::format("its checks crashed: signal {} ({})", end->signal, strsignal(end->signal))
                           : fmt::format("its checks ended with exit code {}", end->exit_code));
    }

    bool take(Slot& slot, std::string_view line) {
        if (line == bake::kOutOfMemoryLine.substr(0, bake::kOutOfMemoryLine.size() - 1)) {
            slot.is_short = true;
            return true;
        }
        if (line.starts_with(kBegin)) {
            std::size_t k = 0;
            line.remove_prefix(kBegin.size());
            const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), k);
            if (error != std::errc{} || slot.file || k >= results_.size() || results_[k]) return false;
            slot.file = k;
            slot.has_begun = true;
            slot.started = Clock::now();
            stillborn_ = 0;
            return true;
        }
        if (!line.starts_with(kEnd) || !slot.file) return false;
        std::optional<FileValidation> result = decode_result(line.substr(kEnd.size()));
        if (!result) return false;
        result->path = name_(*slot.file);
        results_[*slot.file] = std::move(result);
        slot.file.reset();
        slot.is_short = false;
        return true;
    }

    /// Ends the copy, whose file has that finding. @return true
    bool give_up(Slot& slot, const model::Code& code, const std::string& message) {
        slot.child.kill();
        if (slot.file) results_[*slot.file] = failed(name_(*slot.file), code, message);
        return true;
    }

    /// A copy that ended before its first file. Where the system has not what a copy begins with, the next one ends
    /// alike: after some in a row the next file is told to be unchecked.
    void count_stillborn(const bake::ChildEnd& end) {
        constexpr int kMost = 8;
        if (next_.taken() >= results_.size() || ++stillborn_ < kMost) return;
        stillborn_ = 0;
        const std::size_t k = next_.take();
        if (k < results_.size() && !results_[k])
            results_[k] = failed(
                name_(k), codes::kSystemBusy,
                fmt::format("its checks could not begin, {} times in a row ({} {})", kMost,
                            end.signal != 0 ? "signal" : "exit code", end.signal != 0 ? end.signal : end.exit_code));
    }

    void judge_forgotten() {
        for (std::size_t k = 0; k < results_.size(); ++k)
            if (!results_[k])
                results_[k] = failed(name_(k), codes::kWorkerKilled, "its checks were ended from outside");
    }

    const FileLimits& limits_;
    const std::function<FileValidation(std::size_t)>& validate_;
    const std::function<std::filesystem::path(std::size_t)>& name_;
    const std::function<void(std::size_t, FileValidation&)>& done_;
    unsigned jobs_;
    SharedCounter next_;
    std::size_t told_ = 0;
    int stillborn_ = 0;  ///< copies in a row
    std::vector<std::optional<FileValidation>> results_;
    std::list<Slot> slots_;  ///< last: they are killed first
};

void put_findings(bake::ByteWriter& out, const formats::FileFindings& findings) {
    out.put_each(findings, [&](const formats::Finding& f) {
        out.put(std::int32_t{f.code->number});
        out.put(f.severity);
        out.put(f.message);
        out.put(f.place);
        put_optional(out, f.measured);
        put_optional(out, f.limit);
    });
}

bool get_findings(bake::ByteReader& in, formats::FileFindings& findings) {
    bool known = true;
    in.get_each([&] {
        formats::Finding& f = findings.emplace_back();
        f.code = bake::code_of(static_cast<std::uint64_t>(in.get<std::int32_t>()));
        known = known && f.code != nullptr;
        f.severity = in.get<formats::Severity>();
        known = known && f.severity >= formats::Severity::kError && f.severity <= formats::Severity::kNote;
        f.message = in.text();
        f.place = in.text();
        get_optional(in, f.measured);
        get_optional(in, f.limit);
    });
    return known && in.ok();
}

}  // namespace

std::string encode_result(const FileValidation& result) {
    bake::ByteWriter out;
    put_findings(out, result.findings);
    out.put(std::uint64_t{result.charts});
    put_optional(out, result.error);
    put_optional(out, result.turned_faces);
    std::string text;
    for (const char c : out.take()) {
        text += static_cast<char>('a' + (static_cast<unsigned char>(c) >> 4));
        text += static_cast<char>('a' + (static_cast<unsigned char>(c) & 15));
    }
    return text;
}

std::optional<FileValidation> decode_result(std::string_view text) {
    std::string bytes;
    for (std::size_t k = 0; k + 1 < text.size(); k += 2) {
        const int high = text[k] - 'a', low = text[k + 1] - 'a';
        if (high < 0 || high > 15 || low < 0 || low > 15) return std::nullopt;
        bytes += static_cast<char>(16 * high + low);
    }
    bake::ByteReader in(bytes);
    FileValidation out;
    if (!get_findings(in, out.findings)) return std::nullopt;
    out.charts = in.get<std::uint64_t>();
    get_optional(in, out.error);
    get_optional(in, out.turned_faces);
    return in.at_end() ? std::optional(std::move(out)) : std::nullopt;
}

std::vector<FileValidation> validate_apart(std::size_t count, unsigned jobs, const FileLimits& limits,
                                           const std::function<FileValidation(std::size_t)>& validate,
                                           const std::function<std::filesystem::path(std::size_t)>& name,
                                           const std::function<void(std::size_t, FileValidation&)>& done) {
    return ApartRun(count, jobs, limits, validate, name, done).run();
}

}  // namespace dgm::validate
