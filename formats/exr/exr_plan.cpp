// SPDX-License-Identifier: GPL-3.0-or-later
// formats/exr/exr_plan.cpp
#include "exr/exr_plan.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "model/codes.h"
#include "model/layer_names.h"

namespace dgm::formats {
namespace {

using model::Chart;
using model::Layer;

/// Tables up to here go into the header, where they are in nobody's way; larger ones have a file of their own.
constexpr std::uint64_t kMaxHeaderTableBytes = std::uint64_t{4} << 20;

[[noreturn]] void refuse(const std::string& message, const std::string& place) {
    throw model::Error(model::codes::kBadLayerShape, message, place);
}

/// A name becomes part of a file's name, too.
bool is_clean_name(const std::string& name) {
    return !name.empty() && name.size() <= 64 &&
           std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c != '/' && c != '\x7f'; });
}

class Planner {
 public:
    Planner(const std::vector<Chart>& charts, ExrLayout layout) : charts_(charts), layout_(layout) {
        plan_.files.emplace_back();
    }

    ExrPlan run() {
        for (std::size_t k = 0; k < charts_.size(); ++k) plan_chart(k);
        if (plan_.files.front().parts.empty()) plan_.files.front().parts.emplace_back();
        for (PlannedFile& file : plan_.files) name_channels(file);
        check_names();
        return std::move(plan_);
    }

 private:
    [[nodiscard]] std::string prefixed(std::size_t chart, const std::string& layer) const {
        const std::string prefix = charts_.size() > 1 ? "chart" + std::to_string(chart) : "";
        return prefix + (prefix.empty() || layer.empty() ? "" : ".") + layer;
    }

    void plan_chart(std::size_t number) {
        const Chart& chart = charts_[number];
        const std::string place = "chart " + std::to_string(number);
        if (chart.rows == 0 || chart.cols == 0 || chart.rows > kMaxExrWidth || chart.cols > kMaxExrWidth)
            refuse("a grid of " + std::to_string(chart.rows) + " x " + std::to_string(chart.cols), place);
        std::set<std::string> names;
        for (std::size_t k = 0; k < chart.layers.size(); ++k) {
            const Layer& layer = chart.layers[k];
            if (!is_clean_name(layer.name) || !names.insert(layer.name).second)
                refuse("the layer's name is not clean text, or used twice", place + ", layer " + layer.name);
            const auto bytes = exr_layer_bytes(layer.type, layer.shape);
            if (!bytes) refuse("the layer is impossibly large", place + ", layer " + layer.name);
            if (*bytes > 0) plan_layer({number, k}, *bytes);
        }
    }

    void plan_layer(const LayerNumber& number, std::uint64_t bytes) {
        const Chart& chart = charts_[number.chart];
        const Layer& layer = chart.layers[number.layer];
        LayerImage image = image_of_layer(layer.name, layer.type, layer.shape, true);
        if (fits_grid(image, chart.rows, chart.cols)) {
            place_in_grid(number, std::move(image));
        } else if (image.is_table && bytes <= kMaxHeaderTableBytes) {
            plan_.tables.push_back(number);
        } else {
            image = image_of_layer(layer.name, layer.type, layer.shape, false);
            PlannedFile& file = plan_.files.emplace_back();
            file.name = prefixed(number.chart, layer.name);
            PlannedPart& part = file.parts.emplace_back();
            part.width = image.width;
            part.height = image.height;
            part.layers.push_back({number, std::move(image)});
        }
    }

    /// Charts of one size share a file; the first size is that of the map's own.
    void place_in_grid(const LayerNumber& number, LayerImage image) {
        const auto [entry, is_new] =
            grids_.try_emplace({image.width, image.height}, grids_.empty() ? 0 : plan_.files.size());
        if (is_new && entry->second != 0) plan_.files.emplace_back().name = prefixed(number.chart, "");
        std::vector<PlannedPart>& parts = plan_.files[entry->second].parts;
        const bool multipart = layout_ == ExrLayout::kMultipart;
        const bool starts = parts.empty() || multipart || parts.back().layers.front().number.chart != number.chart;
        if (starts) {
            PlannedPart& part = parts.emplace_back();
            part.name = prefixed(number.chart, multipart ? charts_[number.chart].layers[number.layer].name : "");
            part.width = image.width;
            part.height = image.height;
        }
        parts.back().layers.push_back({number, std::move(image)});
    }

    /// Readers of a single picture, such as engines, look for R, G, B or Y in a file without parts. Some of those that
    /// read several parts (Blender 3.4) take all channels for channels of one, so that charts have to differ in them.
    void name_channels(PlannedFile& file) const {
        for (PlannedPart& part : file.parts) {
            const bool alone = file.parts.size() == 1;
            if (alone) part.name.clear();
            for (PlannedLayer& layer : part.layers) {
                const std::string& name = charts_[layer.number.chart].layers[layer.number.layer].name;
                if (alone && (name == model::layers::kGeometry || part.layers.size() == 1))
                    use_root_names(layer.image, name);
                if (alone || charts_.size() == 1) continue;
                for (Channel& channel : layer.image.channels) channel.name = prefixed(layer.number.chart, channel.name);
            }
        }
    }

    void check_names() const {
        std::set<std::string> files;
        for (const PlannedFile& file : plan_.files) {
            if (!files.insert(file.name).second) refuse("two layers need the file " + file.name, "");
            for (const PlannedPart& part : file.parts) {
                std::set<std::string> channels;
                for (const PlannedLayer& layer : part.layers)
                    for (const Channel& channel : layer.image.channels)
                        if (!channels.insert(channel.name).second)
                            refuse("two layers need the channel " + channel.name, part.name);
            }
        }
    }

    const std::vector<Chart>& charts_;
    ExrLayout layout_;
    ExrPlan plan_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> grids_;  ///< the file of a size
};

}  // namespace

ExrPlan plan_exr(const std::vector<Chart>& charts, ExrLayout layout) {
    return Planner(charts, layout).run();
}

}  // namespace dgm::formats
