// SPDX-License-Identifier: GPL-3.0-or-later
// cli/validate/run.cpp
#include "validate/run.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

#include "model/codes.h"
#include "validate/run_apart.h"

namespace dgm::validate {
namespace {
namespace fs = std::filesystem;

/// The checks of a map take some times its layers: those that leave no room are not read.
constexpr std::uint64_t kLayerShare = 4;

/// A source that cannot be read, as the one finding of its file.
FileValidation failed_source(const fs::path& path, const model::Error& error) {
    FileValidation out;
    out.path = path;
    // OBJ readers say FILE:LINE; the file is named already.
    std::string place = error.place();
    if (place == path.string()) place.clear();
    out.findings.push_back({&error.code(), formats::Severity::kError, error.what(), std::move(place), {}, {}});
    return out;
}

/// Files are taken in order, by whichever thread is free; results are handed over in order.
template <class Work>
void in_order(std::size_t count, unsigned jobs, std::vector<FileValidation>& results, const Work& work,
              const std::function<void(const FileValidation&)>& done) {
    std::atomic<std::size_t> next{0};
    std::mutex mutex;
    std::condition_variable finished;
    std::vector<bool> is_done(count, false);
    std::exception_ptr failure;
    const auto loop = [&] {
        for (std::size_t k = next++; k < count; k = next++) {
            try {
                FileValidation result = work(k);
                const std::lock_guard lock(mutex);
                results[k] = std::move(result);
            } catch (...) {
                const std::lock_guard lock(mutex);
                if (!failure) failure = std::current_exception();
                next = count;
            }
            {
                const std::lock_guard lock(mutex);
                is_done[k] = true;
            }
            finished.notify_one();
        }
    };
    std::vector<std::jthread> threads;
    const auto wanted = static_cast<unsigned>(std::min<std::size_t>(std::max(jobs, 1u), count));
    for (unsigned k = 0; k < wanted; ++k) threads.emplace_back(loop);
    try {
        for (std::size_t k = 0; k < count; ++k) {
            std::unique_lock lock(mutex);
            finished.wait(lock, [&] { return is_done[k] || failure; });
            if (failure) break;
            lock.unlock();
            if (done) done(results[k]);
        }
    } catch (...) {
        next = count;  // the threads finish the file they are at
        throw;
    }
    threads.clear();
    if (failure) std::rethrow_exception(failure);
}
}  // namespace

std::vector<FileValidation> run_validation(const RunOptions& options,
                                           const std::function<void(const FileValidation&)>& done) {
    std::vector<FileValidation> front;
    std::optional<Source> source;
    std::error_code ignored;
    const bool by_name = !options.source.empty() && fs::is_directory(options.source, ignored);
    if (!options.source.empty() && !by_name) {
        try {
            source = load_source(options.source, options.read_mesh);
        } catch (const model::Error& error) {
            front.push_back(failed_source(options.source, error));
            apply_rules(options.severities, front.back());
            options.baseline.apply(front.back());
            if (done) done(front.back());
        }
    }
    const auto judge = [&](FileValidation& result) {
        apply_rules(options.severities, result);
        options.baseline.apply(result);
    };
    const auto validate = [&](std::size_t k) {
        Options each;
        if (options.limits && options.limits->memory_bytes != 0)
            each.max_layer_bytes = options.limits->memory_bytes / kLayerShare;
        each.source = source ? &*source : nullptr;
        if (by_name) each.source_folder = options.source;
        each.read_mesh = options.read_mesh;
        each.max_rms_percent = options.max_rms_percent;
        each.max_hausdorff_percent = options.max_hausdorff_percent;
        return validate_file(options.files[k], each);
    };
    std::vector<FileValidation> results(options.files.size());
    if (options.limits) {
        results = validate_apart(
            options.files.size(), options.jobs, *options.limits, validate,
            [&](std::size_t k) { return options.files[k]; },
            [&](std::size_t, FileValidation& result) {
                judge(result);
                if (done) done(result);
            });
    } else {
        const auto work = [&](std::size_t k) {
            FileValidation result = validate(k);
            judge(result);
            return result;
        };
        in_order(options.files.size(), options.jobs, results, work, done);
    }
    front.insert(front.end(), std::make_move_iterator(results.begin()), std::make_move_iterator(results.end()));
    return front;
}

model::ExitCode worst_exit(const std::vector<FileValidation>& files) {
    model::ExitCode worst = model::ExitCode::kOk;
    for (const FileValidation& file : files) worst = model::worse(worst, file.exit_code());
    return worst;
}

}  // namespace dgm::validate
