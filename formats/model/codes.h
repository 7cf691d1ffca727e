// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/codes.h
// Every finding and failure the tools can report. Numbers are stable and never reused; new rows go to the end of
// their range. --explain and docs/codes.md are made of kAll at the bottom.
#pragma once
#include "model/error.h"

namespace dgm::model::codes {

// 1xxx container and index
inline constexpr Code kNotDgm{1001,
                              "NOT_DGM",
                              ExitCode::kInvalid,
                              "the file is not a .dgm",
                              "bake it again with dgm-bake, or check that the download is complete",
                              "no reader can make sense of the bytes"};
inline constexpr Code kBadVersion{1002,
                                  "BAD_VERSION",
                                  ExitCode::kUnsupported,
                                  "the format version is newer than this tool",
                                  "update the tools, or bake again with the installed version",
                                  "this tool would misread what a later version may mean by the same bytes"};
inline constexpr Code kHashMismatch{
    1003,
    "HASH_MISMATCH",
    ExitCode::kInvalid,
    "stored bytes differ from their hash",
    "the file was changed after the bake: bake it again, or, if you painted its layers, use dgm-edit --repair",
    "a damaged file still opens and still draws, only wrongly"};
inline constexpr Code kTruncated{1004,
                                 "TRUNCATED",
                                 ExitCode::kInvalid,
                                 "the file is shorter than its index says",
                                 "copy it again, or bake it again",
                                 "layers at the end are missing; a program that maps the file would read beyond it"};
inline constexpr Code kBadIndex{
    1005,
    "BAD_INDEX",
    ExitCode::kInvalid,
    "the index in the user block is inconsistent",
    "bake it again; tools such as h5repack move datasets and invalidate the index",
    "the runtime reads through the index: a wrong entry makes it read other bytes, or refuse the file"};
inline constexpr Code kHdf5Unreadable{1006,
                                      "HDF5_UNREADABLE",
                                      ExitCode::kInvalid,
                                      "HDF5 cannot read the file",
                                      "bake it again",
                                      "h5py, HDFView and dgm-export cannot open it, although the runtime may"};
inline constexpr Code kExrUnreadable{1007,
                                     "EXR_UNREADABLE",
                                     ExitCode::kInvalid,
                                     "OpenEXR cannot read the file as a geometry map",
                                     "write it again with dgm-bake --format exr or dgm-export",
                                     "without a readable EXR the .dgm cannot be made again"};
inline constexpr Code kLayersOverlap{1008,
                                     "LAYERS_OVERLAP",
                                     ExitCode::kInvalid,
                                     "two layers share bytes",
                                     "bake it again",
                                     "an editor that changes one layer changes the other, too"};
inline constexpr Code kBadAlignment{1009,
                                    "BAD_ALIGNMENT",
                                    ExitCode::kInvalid,
                                    "a layer does not start at a multiple of 64 bytes",
                                    "bake it again",
                                    "vector loops read mapped layers in place and need their alignment"};
inline constexpr Code kForeignStorage{
    1010,
    "FOREIGN_STORAGE",
    ExitCode::kInvalid,
    "a dataset is not plain bytes inside this file",
    "bake it again; links, filters, chunks and external storage are refused, not followed",
    "the runtime maps plain bytes; a link could lead to any file of the user who opens this one"};
inline constexpr Code kIndexDiffers{
    1011,
    "INDEX_DIFFERS",
    ExitCode::kInvalid,
    "HDF5 and the index disagree",
    "bake it again; tools such as h5repack and h5py move or change data that the index describes",
    "HDF5 tools and the runtime would see two different assets in one file"};
inline constexpr Code kUnknownLayer{1012,
                                    "UNKNOWN_LAYER",
                                    ExitCode::kUnsupported,
                                    "the file requires a layer that this tool does not know",
                                    "update the tools",
                                    "the file says that it cannot be understood without that layer"};
inline constexpr Code kBadAttribute{1013,
                                    "BAD_ATTRIBUTE",
                                    ExitCode::kInvalid,
                                    "an HDF5 attribute is missing or of the wrong kind",
                                    "bake it again",
                                    "HDF5 tools find domain, frame and levels in attributes alone"};
inline constexpr Code kUnknownObject{1014,
                                     "UNKNOWN_OBJECT",
                                     ExitCode::kInvalid,
                                     "the file contains an object that the format does not define",
                                     "keep notes and other data in files of their own, or bake it again",
                                     "no reader checks such objects, so damage can hide in them"};
inline constexpr Code kNotReproducible{
    1015,
    "NOT_REPRODUCIBLE",
    ExitCode::kInvalid,
    "the file contains values that differ from run to run or from machine to machine",
    "bake it again with dgm-bake; other writers must leave out dates, hosts and folders",
    "same input, same bytes: caches, reviews and signatures rely on it, and paths reveal private names"};
inline constexpr Code kMissingChannel{1016,
                                      "MISSING_CHANNEL",
                                      ExitCode::kInvalid,
                                      "an EXR lacks a channel or part, or has it with another type or size",
                                      "save all channels with the names that they had, in 32-bit float",
                                      "the layer that the channel belongs to cannot be made again"};
inline constexpr Code kEditForbidden{
    1017,
    "EDIT_FORBIDDEN",
    ExitCode::kInvalid,
    "an edit changes what may not be edited",
    "leave that layer as it was, or change the mesh and bake it again; docs/editing.md lists what may be painted",
    "positions, topology and the tables made of them belong together; one of them changed alone misleads every reader"};
inline constexpr Code kEditUnrelated{
    1018,
    "EDIT_UNRELATED",
    ExitCode::kInvalid,
    "an edit does not fit the map",
    "name the map that was exported, and the files that were made of it, in their own size",
    "values of another grid would be painted on the wrong places of the surface"};
inline constexpr Code kEditedMap{
    1019,
    "EDITED_MAP",
    ExitCode::kInvalid,
    "a bake would throw away what dgm-edit has put into the map",
    "bake to another name with -o and put the paint in with dgm-edit --from, or give it up with --force",
    "paint is hours of somebody's work, and the mesh does not contain it"};

// 2xxx layers and their values
inline constexpr Code kMissingLayer{
    2001,
    "MISSING_LAYER",
    ExitCode::kInvalid,
    "a required layer is missing",
    "bake again with the layer in --layers",
    "readers of that layer have nothing to read, and a free domain without its mask has no surface"};
inline constexpr Code kBadLayerShape{
    2002,
    "BAD_LAYER_SHAPE",
    ExitCode::kInvalid,
    "a layer has the wrong type or shape",
    "bake it again",
    "a reader that trusts the table of layers would read other numbers than were written"};
inline constexpr Code kNotFinite{
    2003,
    "NOT_FINITE",
    ExitCode::kInvalid,
    "a layer contains NaN or infinity",
    "bake it again",
    "one NaN spreads into normals, boxes and forces, and from there into the whole picture"};
inline constexpr Code kSeamGap{2004,
                               "SEAM_GAP",
                               ExitCode::kInvalid,
                               "samples of one weld class differ",
                               "bake it again; editors must write every copy of a seam sample",
                               "the surface shows a crack there, and a tool can fall through it"};
inline constexpr Code kBadSeamTable{
    2005,
    "BAD_SEAM_TABLE",
    ExitCode::kInvalid,
    "the seam table is inconsistent",
    "bake it again",
    "copies that are not joined to their representative tear apart when they are pressed"};
inline constexpr Code kBadTopology{2006,
                                   "BAD_TOPOLOGY",
                                   ExitCode::kInvalid,
                                   "the reconstruction is not a manifold with the recorded topology",
                                   "bake again with a larger --size",
                                   "footprints, strips and volume need a manifold surface; a hole is visible at once"};
inline constexpr Code kBadValue{2007,
                                "BAD_VALUE",
                                ExitCode::kInvalid,
                                "a layer contains a value out of its range",
                                "bake it again",
                                "readers index tables and branch on these values without another check"};
inline constexpr Code kBadCollision{
    2008,
    "BAD_COLLISION",
    ExitCode::kInvalid,
    "a collision box or cover radius misses a part of the surface",
    "bake it again",
    "the collision search skips what lies outside its box, so a tool passes through the surface there"};
inline constexpr Code kBadContact{2009,
                                  "BAD_CONTACT",
                                  ExitCode::kInvalid,
                                  "the sample areas do not add up to the surface area",
                                  "bake it again",
                                  "volume under contact is computed from these areas"};
inline constexpr Code kBadBounds{
    2010,
    "BAD_BOUNDS",
    ExitCode::kInvalid,
    "the bounding box is not that of the reconstruction",
    "bake it again",
    "culling and contact skip what lies outside the box, so parts of the surface vanish or are not felt"};
inline constexpr Code kBadReport{2011,
                                 "BAD_REPORT",
                                 ExitCode::kInvalid,
                                 "the stored report is missing or contradicts the file",
                                 "bake it again",
                                 "tools that sort assets by the numbers in the report sort them wrongly"};
inline constexpr Code kBadMetric{2012,
                                 "BAD_METRIC",
                                 ExitCode::kInvalid,
                                 "the first fundamental form is not that of the geometry",
                                 "bake it again",
                                 "tools that measure with E, F and G get lengths and angles wrong"};
inline constexpr Code kFlippedFaces{2013,
                                    "FLIPPED_FACES",
                                    ExitCode::kInvalid,
                                    "triangles of the map are flipped",
                                    "bake again with --method auto or tutte",
                                    "two places of the surface share one place of the map"};
inline constexpr Code kLooseSamples{2014,
                                    "LOOSE_SAMPLES",
                                    ExitCode::kInvalid,
                                    "samples on the surface belong to no triangle",
                                    "bake it again",
                                    "they cost memory, are never seen, and a tool can be caught by them"};
inline constexpr Code kBadNormal{2015,
                                 "BAD_NORMAL",
                                 ExitCode::kInvalid,
                                 "a normal is not an octahedral code, or most normals point against their faces",
                                 "bake it again; turn normals of the source that point inwards",
                                 "lighting and the hit test take the side from the normal"};
inline constexpr Code kBadReversed{
    2016,
    "BAD_REVERSED",
    ExitCode::kInvalid,
    "the layer `reversed` does not say on which sides of the seams the surface lies",
    "bake it again",
    "normals of seam copies are welded with the wrong sign, so they cancel or point into the surface"};

// 3xxx source mesh and bake
inline constexpr Code kNoFaces{3001,
                               "NO_FACES",
                               ExitCode::kInvalid,
                               "the mesh has no usable faces",
                               "export the mesh with its polygons; point clouds and lines cannot be baked",
                               "there is no surface to map"};
inline constexpr Code kNonOrientable{
    3002,
    "NON_ORIENTABLE",
    ExitCode::kInvalid,
    "the surface is non-orientable",
    "bake it with this version, which opens such a surface along a seam and warns (DGM3017)",
    "a surface without sides has no outside, so neither normals nor pressing inwards mean anything"};
inline constexpr Code kMapInvalid{3003,
                                  "MAP_INVALID",
                                  ExitCode::kInvalid,
                                  "no valid map was found",
                                  "try --method auto or --method tutte, or a larger --size",
                                  "a map with a fold draws a part of the surface twice and another not at all"};
inline constexpr Code kMethodUnsuited{3004,
                                      "METHOD_UNSUITED",
                                      ExitCode::kInvalid,
                                      "the method does not suit this mesh",
                                      "use --method auto",
                                      "the method would fold or collapse this surface"};
inline constexpr Code kImportFailed{3005,
                                    "IMPORT_FAILED",
                                    ExitCode::kInvalid,
                                    "the mesh file cannot be read",
                                    "open it in a modeller and export it again as OBJ",
                                    "a mesh that cannot be read cannot be baked"};
inline constexpr Code kGridTooSmall{
    3006,
    "GRID_TOO_SMALL",
    ExitCode::kInvalid,
    "the grid is too small for this surface",
    "use a larger --size",
    "seams and holes need samples of their own; with fewer, the surface would change its shape"};
inline constexpr Code kTooLarge{3007,
                                "TOO_LARGE",
                                ExitCode::kInvalid,
                                "the input is beyond the tool's limits",
                                "make the input smaller: split or decimate the mesh, or scale the picture down",
                                "time and memory would not be bounded"};
inline constexpr Code kScaleOutOfRange{3008,
                                       "SCALE_OUT_OF_RANGE",
                                       ExitCode::kInvalid,
                                       "the mesh is too large or too small for single precision",
                                       "scale the mesh in your modeller, or choose other units",
                                       "single precision would lose the shape, or overflow"};
inline constexpr Code kErrorNotReached{3009,
                                       "ERROR_NOT_REACHED",
                                       ExitCode::kInvalid,
                                       "no grid that is allowed holds the asked error",
                                       "ask for a larger --max-error, allow a larger --size, or try --fit best",
                                       "the file would not be as accurate as was asked"};
inline constexpr Code kBudgetTooSmall{3010,
                                      "BUDGET_TOO_SMALL",
                                      ExitCode::kInvalid,
                                      "the requested grid and layers do not fit into the budget",
                                      "raise --budget, ask for fewer --layers, or take --precision u16",
                                      "the file would be larger than was asked"};
inline constexpr Code kMaterialsMissing{3011,
                                        "MATERIALS_MISSING",
                                        ExitCode::kInvalid,
                                        "a material library (MTL) that the mesh names is not there",
                                        "put it beside the mesh, or export the mesh again together with its materials",
                                        "without it the mesh has neither colours nor textures"};
inline constexpr Code kTextureMissing{3012,
                                      "TEXTURE_MISSING",
                                      ExitCode::kInvalid,
                                      "a picture that a material names is not there",
                                      "put it beside the mesh or into a folder called textures there",
                                      "the texture layer would show plain colours where the picture should be"};
inline constexpr Code kReferenceOutside{3013,
                                        "REFERENCE_OUTSIDE",
                                        ExitCode::kInvalid,
                                        "a file that the mesh names lies outside the mesh's folder",
                                        "copy it beside the mesh, or allow its folder with --asset-root DIR",
                                        "a mesh from elsewhere could have any private picture baked into its texture"};
inline constexpr Code kReferenceNoFile{3014,
                                       "REFERENCE_NO_FILE",
                                       ExitCode::kInvalid,
                                       "a file that the mesh names is a pipe, a socket or a device",
                                       "put a regular file in its place",
                                       "reading it could wait for ever, or change what it stands for"};
inline constexpr Code kOneSided{3017,
                                "ONE_SIDED",
                                ExitCode::kInvalid,
                                "the surface has one side",
                                "if it should have an inside, look for faces that are joined wrongly, and repair them",
                                "it encloses no volume, and its normals point to opposite sides along a seam"};

inline constexpr Code kBodyTooSmall{3018,
                                    "BODY_TOO_SMALL",
                                    ExitCode::kInvalid,
                                    "the material bends over a length beyond the body",
                                    "check --unit, and bending and membrane of --material",
                                    "the body would move like a stone, and its physics could not be solved"};
inline constexpr Code kPolygonCrosses{
    3019,
    "POLYGON_CROSSES",
    ExitCode::kInvalid,
    "polygons with many corners cross themselves",
    "split them into triangles in your modeller, or delete them",
    "their inside is not defined, and triangles that lie over one another have no map"};

// 4xxx reconstruction against source
inline constexpr Code kRmsExceeded{4001,
                                   "RMS_EXCEEDED",
                                   ExitCode::kInvalid,
                                   "the root mean square distance to the source is above the limit",
                                   "bake again with a larger --size, or another --method",
                                   "on average the surface is not as near to its source as was claimed or asked"};
inline constexpr Code kHausdorffExceeded{4002,
                                         "HAUSDORFF_EXCEEDED",
                                         ExitCode::kInvalid,
                                         "the largest distance to the source is above the limit",
                                         "bake again with a larger --size, or another --method",
                                         "somewhere the surface is not as near to its source as was claimed or asked"};
inline constexpr Code kSourceDiffers{4003,
                                     "SOURCE_DIFFERS",
                                     ExitCode::kInvalid,
                                     "the source is not the file that was baked",
                                     "name the mesh that was baked, or bake this one",
                                     "errors are measured against another mesh than the bake saw"};
inline constexpr Code kTurnedFaces{4004,
                                   "TURNED_FACES",
                                   ExitCode::kInvalid,
                                   "triangles of the reconstruction are inverted against the source",
                                   "bake again with a larger --size, another --method, or --fit best",
                                   "the surface is folded there: lighting and the hit test see its back"};
inline constexpr Code kTopologyDiffers{4005,
                                       "TOPOLOGY_DIFFERS",
                                       ExitCode::kInvalid,
                                       "the reconstruction has another topology than the source",
                                       "bake again with a larger --size, or name the mesh that was baked",
                                       "a hole was closed or opened, a handle lost, or a piece left out"};

// 5xxx files and system
inline constexpr Code kFileMissing{5001,
                                   "FILE_MISSING",
                                   ExitCode::kIo,
                                   "the file or folder does not exist",
                                   "check the path",
                                   "there is nothing to work on"};
inline constexpr Code kReadFailed{5002,
                                  "READ_FAILED",
                                  ExitCode::kIo,
                                  "the file cannot be read",
                                  "check its permissions",
                                  "a file that cannot be read cannot be checked"};
inline constexpr Code kWriteFailed{5003,
                                   "WRITE_FAILED",
                                   ExitCode::kIo,
                                   "the output cannot be written",
                                   "check the folder's permissions and free space",
                                   "the result would be lost"};
inline constexpr Code kNothingToDo{5004,
                                   "NOTHING_TO_BAKE",
                                   ExitCode::kIo,
                                   "no mesh files were found",
                                   "name a mesh file, or a folder or pattern with mesh files in it",
                                   "a batch that finds nothing is more often a wrong path than an empty folder"};
inline constexpr Code kImageUnreadable{5005,
                                       "IMAGE_UNREADABLE",
                                       ExitCode::kInvalid,
                                       "the picture cannot be decoded",
                                       "save it again as PNG or JPEG",
                                       "the texture layer would be wrong without a warning"};
inline constexpr Code kNoSpace{5006,
                               "NO_SPACE",
                               ExitCode::kTransient,
                               "the output's disk is full",
                               "free some space, then run it again: finished assets are not baked twice",
                               "nothing half-written is left; the asset is as it was before"};
inline constexpr Code kIoTrouble{5007,
                                 "IO_TROUBLE",
                                 ExitCode::kTransient,
                                 "the file system failed for the moment",
                                 "run it again; if it stays so, look at the disk or the network share",
                                 "the asset may be good, so a batch system should try it again"};
inline constexpr Code kReportUnreadable{
    5008,
    "REPORT_UNREADABLE",
    ExitCode::kInvalid,
    "the report cannot be used",
    "write it again with dgm-bake --report; outputs that are up to date are not baked twice",
    "a merged report that leaves out a part would hide its failures"};

// 6xxx usage
inline constexpr Code kUsage{6001,
                             "USAGE",
                             ExitCode::kUsage,
                             "the command line is wrong",
                             "see --help",
                             "a guess could do something else than you meant"};
inline constexpr Code kUnsupported{6002,
                                   "UNSUPPORTED",
                                   ExitCode::kUnsupported,
                                   "this is not supported",
                                   "see --help",
                                   "doing a part of it would look like all of it"};
inline constexpr Code kBadBaseline{6003,
                                   "BAD_BASELINE",
                                   ExitCode::kUsage,
                                   "the baseline cannot be read",
                                   "write it again with --write-baseline",
                                   "without its baseline a run would fail for known findings, or pass new ones"};
inline constexpr Code kSceneInvalid{6004,
                                    "SCENE_INVALID",
                                    ExitCode::kInvalid,
                                    "the scene file is wrong",
                                    "docs/scenes.md has every key; the message gives line and column",
                                    "a misread value would bake another scene than the one you meant"};

inline constexpr Code kMaterialInvalid{6005,
                                       "MATERIAL_INVALID",
                                       ExitCode::kInvalid,
                                       "the material file is wrong",
                                       "docs/options.md has every key; the message gives line and column",
                                       "a misread number would make another body than the one you meant"};

// 9xxx internal
inline constexpr Code kInternal{9001,
                                "INTERNAL",
                                ExitCode::kInternal,
                                "internal error",
                                "report it with the input file",
                                "the tool itself is wrong: its result cannot be trusted"};
inline constexpr Code kWorkerCrashed{9002,
                                     "WORKER_CRASHED",
                                     ExitCode::kInternal,
                                     "the worker process crashed",
                                     "report it with the input file; other assets were not affected",
                                     "the mesh made a library abort; the other assets were not affected"};
inline constexpr Code kWorkerTimeout{9003,
                                     "WORKER_TIMEOUT",
                                     ExitCode::kInvalid,
                                     "the worker ran out of time",
                                     "raise --time-limit, ask for a smaller --size, or decimate the mesh",
                                     "one asset must not stop a batch"};
inline constexpr Code kWorkerMemory{9004,
                                    "WORKER_MEMORY",
                                    ExitCode::kInvalid,
                                    "the worker ran out of memory",
                                    "raise --memory-limit, ask for a smaller --size, or decimate the mesh",
                                    "one asset must not take the machine's memory"};
inline constexpr Code kInterrupted{9005,
                                   "INTERRUPTED",
                                   ExitCode::kInterrupted,
                                   "the bake was interrupted",
                                   "run it again",
                                   "unfinished outputs were not written"};
inline constexpr Code kWorkerKilled{9006,
                                    "WORKER_KILLED",
                                    ExitCode::kTransient,
                                    "the worker process was killed from outside",
                                    "run it again, with a smaller -j if the machine ran short of memory",
                                    "the asset may be good, so a batch system should try it again"};
inline constexpr Code kSystemBusy{9007,
                                  "SYSTEM_BUSY",
                                  ExitCode::kTransient,
                                  "the system has no process, descriptor or memory left for now",
                                  "run it again when less is running, or with a smaller -j",
                                  "the asset was not tried, so nothing is known of it"};

inline constexpr const Code* kAll[] = {
    &kNotDgm,           &kBadVersion,       &kHashMismatch,
    &kTruncated,        &kBadIndex,         &kHdf5Unreadable,
    &kExrUnreadable,    &kLayersOverlap,    &kBadAlignment,
    &kForeignStorage,   &kIndexDiffers,     &kUnknownLayer,
    &kBadAttribute,     &kUnknownObject,    &kNotReproducible,
    &kMissingChannel,   &kEditForbidden,    &kEditUnrelated,
    &kEditedMap,        &kMissingLayer,     &kBadLayerShape,
    &kNotFinite,        &kSeamGap,          &kBadSeamTable,
    &kBadTopology,      &kBadValue,         &kBadCollision,
    &kBadContact,       &kBadBounds,        &kBadReport,
    &kBadMetric,        &kFlippedFaces,     &kLooseSamples,
    &kBadNormal,        &kBadReversed,      &kNoFaces,
    &kNonOrientable,    &kMapInvalid,       &kMethodUnsuited,
    &kImportFailed,     &kGridTooSmall,     &kTooLarge,
    &kScaleOutOfRange,  &kErrorNotReached,  &kBudgetTooSmall,
    &kMaterialsMissing, &kTextureMissing,   &kReferenceOutside,
    &kReferenceNoFile,  &kOneSided,         &kBodyTooSmall,
    &kPolygonCrosses,   &kRmsExceeded,      &kHausdorffExceeded,
    &kSourceDiffers,    &kTurnedFaces,      &kTopologyDiffers,
    &kFileMissing,      &kReadFailed,       &kWriteFailed,
    &kNothingToDo,      &kImageUnreadable,  &kNoSpace,
    &kIoTrouble,        &kReportUnreadable, &kUsage,
    &kUnsupported,      &kBadBaseline,      &kSceneInvalid,
    &kMaterialInvalid,  &kInternal,         &kWorkerCrashed,
    &kWorkerTimeout,    &kWorkerMemory,     &kInterrupted,
    &kWorkerKilled,     &kSystemBusy,
};

}  // namespace dgm::model::codes
