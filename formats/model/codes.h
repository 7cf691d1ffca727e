// SPDX-License-Identifier: GPL-3.0-or-later
// formats/model/codes.h
// Every finding and failure the tools can report. Numbers are stable and never reused; new rows go to the end of
// their range. kAll at the bottom is what --explain and the docs read.
#pragma once
#include "model/error.h"

namespace dgm::model::codes {

// 1xxx container and index
inline constexpr Code kNotDgm{1001, "NOT_DGM", ExitCode::kInvalid, "the file is not a .dgm",
                              "bake it again with dgm-bake, or check that the download is complete"};
inline constexpr Code kBadVersion{1002, "BAD_VERSION", ExitCode::kUnsupported, "the format version is newer than this tool",
                                  "update the tools, or bake again with the installed version"};
inline constexpr Code kHashMismatch{1003, "HASH_MISMATCH", ExitCode::kInvalid, "stored bytes differ from their hash",
                                    "the file was damaged after the bake; bake it again"};
inline constexpr Code kTruncated{1004, "TRUNCATED", ExitCode::kInvalid, "the file is shorter than its index says",
                                 "copy it again, or bake it again"};
inline constexpr Code kBadIndex{1005, "BAD_INDEX", ExitCode::kInvalid, "the index in the user block is inconsistent",
                                "bake it again; tools such as h5repack move datasets and invalidate the index"};
inline constexpr Code kHdf5Unreadable{1006, "HDF5_UNREADABLE", ExitCode::kInvalid, "HDF5 cannot read the file",
                                      "bake it again"};
inline constexpr Code kExrUnreadable{1007, "EXR_UNREADABLE", ExitCode::kInvalid, "OpenEXR cannot read the file as a geometry map",
                                     "write it again with dgm-bake --format exr or dgm-export"};

// 2xxx layers and their values
inline constexpr Code kMissingLayer{2001, "MISSING_LAYER", ExitCode::kInvalid, "a required layer is missing",
                                    "bake again with the layer in --layers"};
inline constexpr Code kBadLayerShape{2002, "BAD_LAYER_SHAPE", ExitCode::kInvalid, "a layer has the wrong type or shape",
                                     "bake it again"};
inline constexpr Code kNotFinite{2003, "NOT_FINITE", ExitCode::kInvalid, "a layer holds NaN or infinity", "bake it again"};
inline constexpr Code kSeamGap{2004, "SEAM_GAP", ExitCode::kInvalid, "samples of one seam class differ",
                               "bake it again; editors must write every copy of a seam sample"};
inline constexpr Code kBadSeamTable{2005, "BAD_SEAM_TABLE", ExitCode::kInvalid, "the seam table is inconsistent", "bake it again"};
inline constexpr Code kBadTopology{2006, "BAD_TOPOLOGY", ExitCode::kInvalid,
                                   "the reconstruction is not a manifold with the recorded topology",
                                   "bake again with a larger --size"};
inline constexpr Code kBadValue{2007, "BAD_VALUE", ExitCode::kInvalid, "a layer holds a value out of its range", "bake it again"};
inline constexpr Code kBadCollision{2008, "BAD_COLLISION", ExitCode::kInvalid,
                                    "a collision box or cover radius misses a part of the surface", "bake it again"};
inline constexpr Code kBadContact{2009, "BAD_CONTACT", ExitCode::kInvalid,
                                  "the sample areas do not add up to the surface area", "bake it again"};
inline constexpr Code kBadBounds{2010, "BAD_BOUNDS", ExitCode::kInvalid, "the bounding box is not that of the reconstruction",
                                 "bake it again"};
inline constexpr Code kBadReport{2011, "BAD_REPORT", ExitCode::kInvalid, "the stored report is missing or contradicts the file",
                                 "bake it again"};

// 3xxx source mesh and bake
inline constexpr Code kNoFaces{3001, "NO_FACES", ExitCode::kInvalid, "the mesh has no usable faces",
                               "export the mesh with its polygons; point clouds and lines cannot be baked"};
inline constexpr Code kNonOrientable{3002, "NON_ORIENTABLE", ExitCode::kInvalid, "the surface is non-orientable",
                                     "cut the surface open in your modeller so that it has an inside and an outside"};
inline constexpr Code kMapInvalid{3003, "MAP_INVALID", ExitCode::kInvalid, "no valid map was found",
                                  "try --method auto or --method tutte, or a larger --size"};
inline constexpr Code kMethodUnsuited{3004, "METHOD_UNSUITED", ExitCode::kInvalid, "the method does not suit this mesh",
                                      "use --method auto"};
inline constexpr Code kImportFailed{3005, "IMPORT_FAILED", ExitCode::kInvalid, "the mesh file cannot be read",
                                    "open it in a modeller and export it again as OBJ"};
inline constexpr Code kGridTooSmall{3006, "GRID_TOO_SMALL", ExitCode::kInvalid, "the grid is too small for this surface",
                                    "use a larger --size"};
inline constexpr Code kTooLarge{3007, "TOO_LARGE", ExitCode::kInvalid, "the input is beyond the tool's limits",
                                "split or decimate the mesh"};
inline constexpr Code kScaleOutOfRange{3008, "SCALE_OUT_OF_RANGE", ExitCode::kInvalid,
                                       "the mesh is too large or too small for single precision",
                                       "scale the mesh in your modeller, or choose other units"};
inline constexpr Code kErrorNotReached{3009, "ERROR_NOT_REACHED", ExitCode::kInvalid,
                                       "no grid that is allowed holds the asked error",
                                       "ask for a larger --max-error, allow a larger --size, or try --fit best"};
inline constexpr Code kBudgetTooSmall{3010, "BUDGET_TOO_SMALL", ExitCode::kInvalid,
                                      "what was asked for does not fit into the budget",
                                      "raise --budget, ask for fewer --layers, or take --precision u16"};

// 4xxx reconstruction against source
inline constexpr Code kRmsExceeded{4001, "RMS_EXCEEDED", ExitCode::kInvalid,
                                   "the root mean square distance to the source is above the limit",
                                   "bake again with a larger --size, or another --method"};
inline constexpr Code kHausdorffExceeded{4002, "HAUSDORFF_EXCEEDED", ExitCode::kInvalid,
                                         "the largest distance to the source is above the limit",
                                         "bake again with a larger --size, or another --method"};
inline constexpr Code kSourceDiffers{4003, "SOURCE_DIFFERS", ExitCode::kInvalid,
                                     "the source is not the file that was baked",
                                     "name the mesh that was baked, or bake this one"};
inline constexpr Code kTurnedFaces{4004, "TURNED_FACES", ExitCode::kInvalid,
                                   "triangles of the reconstruction look against the source",
                                   "bake again with a larger --size, another --method, or --fit best"};

// 5xxx files and system
inline constexpr Code kFileMissing{5001, "FILE_MISSING", ExitCode::kIo, "the file or folder does not exist", "check the path"};
inline constexpr Code kReadFailed{5002, "READ_FAILED", ExitCode::kIo, "the file cannot be read", "check its permissions"};
inline constexpr Code kWriteFailed{5003, "WRITE_FAILED", ExitCode::kIo, "the output cannot be written",
                                   "check the folder's permissions and free space"};
inline constexpr Code kNothingToDo{5004, "NOTHING_TO_BAKE", ExitCode::kIo, "no mesh files were found",
                                   "name a mesh file, or a folder that holds OBJ or 3DS files"};
inline constexpr Code kImageUnreadable{5005, "IMAGE_UNREADABLE", ExitCode::kInvalid, "the picture cannot be decoded",
                                       "save it again as PNG or JPEG"};
inline constexpr Code kNoSpace{5006, "NO_SPACE", ExitCode::kTransient, "the output's disk is full",
                               "free some space, then run it again: what is done already is not baked twice"};
inline constexpr Code kIoTrouble{5007, "IO_TROUBLE", ExitCode::kTransient, "the file system failed for the moment",
                                 "run it again; if it stays so, look at the disk or the network share"};

inline constexpr Code kReportUnreadable{5008, "REPORT_UNREADABLE", ExitCode::kInvalid, "the report cannot be used",
                                        "write it again with dgm-bake --report; what is up to date is not baked twice"};

// 6xxx usage
inline constexpr Code kUsage{6001, "USAGE", ExitCode::kUsage, "the command line is wrong", "see --help"};
inline constexpr Code kUnsupported{6002, "UNSUPPORTED", ExitCode::kUnsupported, "this is not supported", "see --help"};

// 9xxx internal
inline constexpr Code kInternal{9001, "INTERNAL", ExitCode::kInternal, "internal error", "report it with the input file"};
inline constexpr Code kWorkerCrashed{9002, "WORKER_CRASHED", ExitCode::kInternal, "the worker process crashed",
                                     "report it with the input file; other assets were not affected"};
inline constexpr Code kWorkerTimeout{9003, "WORKER_TIMEOUT", ExitCode::kInvalid, "the worker ran out of time",
                                     "raise --time-limit, or decimate the mesh"};
inline constexpr Code kWorkerMemory{9004, "WORKER_MEMORY", ExitCode::kInvalid, "the worker ran out of memory",
                                    "raise --memory-limit, or decimate the mesh"};
inline constexpr Code kWorkerKilled{9006, "WORKER_KILLED", ExitCode::kTransient,
                                    "the worker process was killed from outside",
                                    "run it again, with a smaller -j if the machine ran short of memory"};
inline constexpr Code kSystemBusy{9007, "SYSTEM_BUSY", ExitCode::kTransient,
                                  "the system has no process, descriptor or memory left for now",
                                  "run it again when less is running, or with a smaller -j"};
inline constexpr Code kInterrupted{9005, "INTERRUPTED", ExitCode::kInterrupted, "the bake was interrupted", "run it again"};

inline constexpr const Code* kAll[] = {
    &kNotDgm, &kBadVersion, &kHashMismatch, &kTruncated, &kBadIndex, &kHdf5Unreadable, &kExrUnreadable,
    &kMissingLayer, &kBadLayerShape, &kNotFinite, &kSeamGap, &kBadSeamTable, &kBadTopology,
    &kBadValue, &kBadCollision, &kBadContact, &kBadBounds, &kBadReport,
    &kNoFaces, &kNonOrientable, &kMapInvalid, &kMethodUnsuited, &kImportFailed, &kGridTooSmall, &kTooLarge, &kScaleOutOfRange,
    &kErrorNotReached, &kBudgetTooSmall,
    &kRmsExceeded, &kHausdorffExceeded, &kSourceDiffers, &kTurnedFaces,
    &kFileMissing, &kReadFailed, &kWriteFailed, &kNothingToDo, &kImageUnreadable, &kNoSpace, &kIoTrouble,
    &kReportUnreadable,
    &kUsage, &kUnsupported,
    &kInternal, &kWorkerCrashed, &kWorkerTimeout, &kWorkerMemory, &kInterrupted, &kWorkerKilled, &kSystemBusy,
};

}  // namespace dgm::model::codes
