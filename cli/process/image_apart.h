// SPDX-License-Identifier: GPL-3.0-or-later
// cli/process/image_apart.h
// Pictures are decoded in disposable processes.
#pragma once
#include "image/image.h"
#include "process/fork_server.h"

namespace dgm::bake {

/// While it lives, formats::read_image(), read_height() and image_bits() read every picture in a process of its own,
/// which can read that file and do nothing else (sandbox.h). If it dies, the picture is unreadable (kImageUnreadable)
/// and the program goes on. For programs; a worker, which is in a sandbox already, has none. Create it as a ForkServer.
class ImageApart {
 public:
    /// @param decoder  works in those processes; another one is for tests
    /// @throws model::Error kSystemBusy
    explicit ImageApart(const formats::ImageReader& decoder = formats::image_reader_here());
    ImageApart(const ImageApart&) = delete;
    ImageApart& operator=(const ImageApart&) = delete;
    ~ImageApart();

 private:
    ForkServer server_;
};

}  // namespace dgm::bake
