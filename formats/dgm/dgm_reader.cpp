// SPDX-License-Identifier: GPL-3.0-or-later
// formats/dgm/dgm_reader.cpp
// One walk over the file serves all entry points: read_dgm stops at the first finding, the others go on and keep the
// findings. The index is checked on the raw bytes first; HDF5 sees the file only once header, index and all hashes are
// good, perhaps in another process (set_hdf5_reader), and then has to agree with the index.
#include "dgm/dgm_reader.h"

#include <algorithm>

#include "dgm/file_index.h"
#include "dgm/finding_list.h"
#include "dgm/h5_comparison.h"
#include "dgm/h5_file.h"
#include "dgm/hash.h"
#include "dgm/raw_file.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;

void read_charts(const FileIndex& file, model::MapSet& maps) {
    const layout::FileHeader& header = file.header;
    maps.format_version = header.format_version;
    std::copy(std::begin(header.source_hash), std::end(header.source_hash), maps.source_hash.begin());
    std::copy(std::begin(header.settings_hash), std::end(header.settings_hash), maps.settings_hash.begin());
    for (const layout::ChartRecord& record : file.index.charts) {
        model::Chart& chart = maps.charts.emplace_back();
        chart.rows = record.rows;
        chart.cols = record.cols;
        chart.domain = static_cast<layout::Domain>(record.domain);
        chart.method = field_text(record.method).value_or(std::string());
        std::copy(std::begin(record.bbox), std::end(record.bbox), chart.bbox.begin());
        std::copy(std::begin(record.offset), std::end(record.offset), chart.offset.begin());
        std::copy(std::begin(record.scale), std::end(record.scale), chart.scale.begin());
    }
}

/// Whether the file's hashes fit, rather than findings.
struct FitList {
    std::vector<std::vector<bool>> layers;  ///< chart by chart
    bool rest = true;
};

/// Whether all layers may be in memory at once, before the first is read: a sparse file of some kilobytes may claim
/// gigabytes.
void check_total(const FileIndex& file, const DgmReadLimits& limits, FindingList& findings) {
    std::uint64_t bytes = 0;  // no overflow: the layers lie in the file and share nothing
    for (const layout::LayerRecord& record : file.index.layers) bytes += record.bytes;
    if (bytes <= limits.max_total_bytes) return;
    findings.add(codes::kTooLarge,
                 "all layers take " + std::to_string(bytes) + " bytes of memory; the limit is " +
                     std::to_string(limits.max_total_bytes),
                 "/charts", static_cast<double>(bytes), static_cast<double>(limits.max_total_bytes));
    throw EnoughFindings();
}

/// The hash of a range that is not kept, which may be as large as the file says.
Hash128 hash_range(const RawFile& raw, std::uint64_t begin, std::uint64_t bytes) {
    constexpr std::uint64_t kBlock = std::uint64_t{1} << 20;
    Hasher hasher;
    for (std::uint64_t done = 0; done < bytes; done += std::min(kBlock, bytes - done))
        hasher.add(raw.read(begin + done, std::min(kBlock, bytes - done)));
    return hasher.result();
}

/// Checks the hashes of all layers, and keeps the layers if `maps` is given.
/// @param fits  gets what differs, which is no finding then
void read_layers(const RawFile& raw, const FileIndex& file, FindingList& findings, model::MapSet* maps, FitList* fits) {
    if (fits != nullptr) fits->layers.resize(file.index.charts.size());
    for (const layout::LayerRecord& record : file.index.layers) {
        std::vector<std::byte> bytes;
        if (maps != nullptr) bytes = raw.read(record.offset, record.bytes);
        const Hash128 hash = maps != nullptr ? hash_bytes(bytes) : hash_range(raw, record.offset, record.bytes);
        const std::string name = field_text(record.name).value_or(std::string());
        const bool is_same = std::equal(hash.begin(), hash.end(), record.hash);
        if (fits != nullptr)
            fits->layers[record.chart].push_back(is_same);
        else if (!is_same)
            findings.add(codes::kHashMismatch, "the layer's bytes differ from their hash",
                         h5_place(record.chart, name));
        if (maps == nullptr) continue;
        model::Layer& layer = maps->charts[record.chart].layers.emplace_back();
        layer.name = name;
        layer.type = static_cast<layout::ElementType>(record.type);
        layer.shape.assign(record.shape, record.shape + record.rank);
        layer.bytes = std::move(bytes);
        layer.required = (record.flags & layout::kLayerRequired) != 0;
    }
}

/// Finds damage to HDF5's own structures before HDF5 sees them. Files of other writers may lack the hash.
void check_rest(const RawFile& raw, const FileIndex& file, FindingList& findings, FitList* fits) {
    const auto& expected = file.header.rest_hash;
    if (std::all_of(std::begin(expected), std::end(expected), [](auto b) { return b == 0; })) return;
    constexpr std::uint64_t kBlock = std::uint64_t{1} << 20, kMost = std::uint64_t{1} << 30;
    const auto ranges = ranges_beside_layers(file.index, raw.size());
    std::uint64_t bytes = 0;
    for (const auto& [begin, end] : ranges) bytes += end - begin;
    if (bytes > kMost) {  // a sparse file may claim terabytes that were never written
        findings.add(codes::kBadIndex, "the file is mostly not layers", "/", static_cast<double>(bytes),
                     static_cast<double>(kMost));
        return;
    }
    Hasher hasher;
    for (auto [begin, end] : ranges)
        for (; begin < end; begin += std::min(kBlock, end - begin))
            hasher.add(raw.read(begin, std::min(kBlock, end - begin)));
    const Hash128 hash = hasher.result();
    const bool is_same = std::equal(hash.begin(), hash.end(), expected);
    if (fits != nullptr)
        fits->rest = is_same;
    else if (!is_same)
        findings.add(codes::kHashMismatch, "HDF5's own structures, or the report, differ from their hash", "/");
}

Hdf5Reader& hdf5_reader() {
    static Hdf5Reader reader;
    return reader;
}

/// Takes over what HDF5 says, from whichever process it comes.
void read_hdf5(const fs::path& path, const DgmReadLimits& limits, const FileIndex& file, FindingList& findings,
               model::MapSet* maps) {
    Hdf5Part part = hdf5_reader() ? hdf5_reader()(path, limits) : read_hdf5_part(path, limits);
    const bool is_whole = part.findings.empty();
    for (Finding& f : part.findings)
        findings.add(*f.code, std::move(f.message), std::move(f.place), f.measured, f.limit);
    if (!is_whole || maps == nullptr) return;
    if (part.attributes.size() != file.index.layers.size())
        throw model::Error(codes::kReadFailed, "the file changed while it was read", path.string());
    maps->generator = std::move(part.generator);
    maps->source_name = std::move(part.source_name);
    maps->report_json = std::move(part.report_json);
    auto attributes = part.attributes.begin();
    for (model::Chart& chart : maps->charts)
        for (model::Layer& layer : chart.layers) layer.attributes = std::move(*attributes++);
}

/// Which layers' bytes are read.
enum class Layers { kKeep, kHash, kSkip };

/// @param throws  the first finding, rather than collecting them
/// @param maps    gets the content of the file, if given
/// @param fits    gets which hashes fit, if given; those that do not are no findings then
FileFindings walk(const fs::path& path, const DgmReadLimits& limits, bool throws, Layers layers, model::MapSet* maps,
                  FitList* fits = nullptr) {
    const RawFile raw(path);
    FindingList findings(throws);
    try {
        if (const auto file = read_file_index(raw, limits, findings)) {
            const std::size_t before = findings.size();
            if (maps != nullptr) read_charts(*file, *maps);
            if (layers == Layers::kKeep) check_total(*file, limits, findings);
            if (layers != Layers::kSkip)
                read_layers(raw, *file, findings, layers == Layers::kKeep ? maps : nullptr, fits);
            check_rest(raw, *file, findings, fits);
            if (findings.size() == before) read_hdf5(path, limits, *file, findings, maps);
        }
    } catch (const EnoughFindings&) {
    } catch (const model::Error& error) {
        if (error.place().starts_with(path.string())) throw;
        throw model::Error(error.code(), error.what(), path.string() + ": " + error.place());
    }
    return findings.take();
}

}  // namespace

Hdf5Part read_hdf5_part(const fs::path& path, const DgmReadLimits& limits) {
    const RawFile raw(path);
    FindingList findings(false);
    Hdf5Part part;
    try {
        if (const auto file = read_file_index(raw, limits, findings))
            compare_with_hdf5(path, raw, *file, findings, part);
    } catch (const EnoughFindings&) {}  // the list is full
    part.findings = findings.take();
    return part;
}

void prepare_hdf5() {
    const H5Session session;
    H5open();
}

void set_hdf5_reader(Hdf5Reader reader) {
    hdf5_reader() = std::move(reader);
}

model::MapSet read_dgm(const fs::path& path, const DgmReadLimits& limits) {
    model::MapSet maps;
    (void)walk(path, limits, true, Layers::kKeep, &maps);
    return maps;
}

model::MapSet read_dgm_head(const fs::path& path, const DgmReadLimits& limits) {
    model::MapSet maps;
    (void)walk(path, limits, true, Layers::kSkip, &maps);
    return maps;
}

ChangedDgm read_changed_dgm(const fs::path& path, const DgmReadLimits& limits) {
    ChangedDgm out;
    FitList fits;
    (void)walk(path, limits, true, Layers::kKeep, &out.maps, &fits);
    out.fits = std::move(fits.layers);
    out.rest_fits = fits.rest;
    return out;
}

FileFindings check_container(const fs::path& path, const DgmReadLimits& limits) {
    return walk(path, limits, false, Layers::kHash, nullptr);
}

FileFindings read_and_check(const fs::path& path, model::MapSet& maps, const DgmReadLimits& limits) {
    return walk(path, limits, false, Layers::kKeep, &maps);
}

}  // namespace dgm::formats
