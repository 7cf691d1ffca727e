// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_stream.h
// The file that OpenEXR writes. Its own stream forgets what fails when the last bytes leave the buffer: on a full disk
// a file without its end would be called good.
#pragma once
#include <ImfIO.h>

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "model/error.h"

namespace dgm::formats {

/// What was caught while `path` was written, but for a lack of memory, which goes on as it is: with write_failure().
[[nodiscard]] model::Error exr_failure(const std::exception& caught, const std::filesystem::path& path);

class ExrStream : public Imf::OStream {
 public:
    /// @throws std::system_error if the file cannot be made
    explicit ExrStream(const std::filesystem::path& path);
    void write(const char bytes[], int count) override;
    // Destructors of OpenEXR call these two where they catch nothing: they remember what fails, and do not throw.
    [[nodiscard]] std::uint64_t tellp() override;
    void seekp(std::uint64_t place) override;
    /// After the end of the Imf file that writes here, whose destructor swallows what fails. Where memory is short for
    /// the last lines, OpenEXR leaves them out without a word.
    /// @throws std::system_error if anything has failed since the start, or lines are missing
    void finish();

 private:
    void note();
    void check();
    std::ofstream out_;
    int error_ = 0;  ///< errno of the first failure
};

}  // namespace dgm::formats
