// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/byte_stream.h
// Values as bytes between a program and its disposable processes, which run the same program on the same machine.
#pragma once
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace dgm::bake {

class ByteWriter {
 public:
    template <class T>
    void put(const T& value) {
        static_assert(std::is_trivially_copyable_v<T>);
        out_.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
    void put(const std::string& text) {
        put(std::uint64_t{text.size()});
        out_ += text;
    }
    template <class T>
    void put_all(const std::vector<T>& values) {
        static_assert(std::is_trivially_copyable_v<T>);
        put(std::uint64_t{values.size()});
        if (!values.empty()) out_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    }
    template <class T, class Put>
    void put_each(const std::vector<T>& values, const Put& put_one) {
        put(std::uint64_t{values.size()});
        for (const T& value : values) put_one(value);
    }
    [[nodiscard]] std::string take() { return std::move(out_); }

 private:
    std::string out_;
};

/// Reads the bytes of ByteWriter. Missing bytes read as zero, and `ok` is false from then on.
class ByteReader {
 public:
    explicit ByteReader(std::string_view bytes) : rest_(bytes) {}
    [[nodiscard]] bool ok() const { return ok_; }
    [[nodiscard]] bool at_end() const { return ok_ && rest_.empty(); }

    template <class T>
    T get() {
        static_assert(std::is_trivially_copyable_v<T>);
        T value{};
        if (const char* bytes = take(sizeof value)) std::memcpy(&value, bytes, sizeof value);
        return value;
    }
    std::string text() {
        const auto size = get<std::uint64_t>();
        const char* bytes = take(size);
        return bytes == nullptr ? std::string() : std::string(bytes, size);
    }
    template <class T>
    void get_all(std::vector<T>& out) {
        static_assert(std::is_trivially_copyable_v<T>);
        const auto size = get<std::uint64_t>();
        const char* bytes = size > rest_.size() / sizeof(T) ? take(rest_.size() + 1) : take(size * sizeof(T));
        if (bytes == nullptr || size == 0) return;
        out.resize(size);
        std::memcpy(static_cast<void*>(out.data()), bytes, size * sizeof(T));
    }
    template <class Get>
    void get_each(const Get& get_one) {
        for (auto left = get<std::uint64_t>(); left > 0 && ok_; --left) get_one();
    }

 private:
    const char* take(std::uint64_t bytes) {
        if (!ok_ || bytes > rest_.size()) {
            ok_ = false;
            return nullptr;
        }
        const char* at = rest_.data();
        rest_.remove_prefix(bytes);
        return at;
    }
    std::string_view rest_;
    bool ok_ = true;
};

}  // namespace dgm::bake
