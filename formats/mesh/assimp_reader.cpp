// SPDX-License-Identifier: GPL-3.0-or-later
// formats/mesh/assimp_reader.cpp
#include "mesh/assimp_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <set>
#include <span>
#include <string_view>
#include <system_error>

#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/metadata.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <assimp/Importer.hpp>

#include "mesh/asset_folders.h"
#include "mesh/guarded_io.h"
#include "mesh/material_files.h"
#include "mesh/mtl_reader.h"
#include "mesh/polygon.h"
#include "mesh/text_input.h"
#include "model/codes.h"

namespace dgm::formats {
namespace {

namespace codes = model::codes;
namespace fs = std::filesystem;
using model::Vec3d;

/// A node's place in the scene, in double: position = linear * p + offset.
struct Placement {
    double linear[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double offset[3] = {0, 0, 0};

    [[nodiscard]] Vec3d point(const Vec3d& p) const {
        Vec3d out;
        for (int r = 0; r < 3; ++r) out[r] = linear[r][0] * p.x + linear[r][1] * p.y + linear[r][2] * p.z + offset[r];
        return out;
    }
    /// Normals go by the matrix of cofactors, which needs no inverse and keeps its sense under reflection.
    [[nodiscard]] Vec3d normal(const Vec3d& n) const {
        const Vec3d a{linear[0][0], linear[1][0], linear[2][0]}, b{linear[0][1], linear[1][1], linear[2][1]},
            c{linear[0][2], linear[1][2], linear[2][2]};
        const Vec3d out = (cross(b, c) * n.x + cross(c, a) * n.y + cross(a, b) * n.z) * (mirrors() ? -1.0 : 1.0);
        return normalized(out, {0, 0, 0});
    }
    /// True if the rows are unit vectors along the axes that make a right-handed frame.
    [[nodiscard]] bool is_rotation() const {
        for (int r = 0; r < 3; ++r) {
            int column = 0, row = 0;
            for (int c = 0; c < 3; ++c) row += linear[r][c] != 0 ? 1 : 0, column += linear[c][r] != 0 ? 1 : 0;
            if (row != 1 || column != 1) return false;
        }
        return !mirrors();
    }
    [[nodiscard]] bool mirrors() const {
        const Vec3d a{linear[0][0], linear[1][0], linear[2][0]}, b{linear[0][1], linear[1][1], linear[2][1]},
            c{linear[0][2], linear[1][2], linear[2][2]};
        return dot(a, cross(b, c)) < 0;
    }
};

Placement operator*(const Placement& parent, const aiMatrix4x4& child) {
    const double m[3][4] = {{child.a1, child.a2, child.a3, child.a4},
                            {child.b1, child.b2, child.b3, child.b4},
                            {child.c1, child.c2, child.c3, child.c4}};
    Placement out;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
            out.linear[r][c] = 0;
            for (int k = 0; k < 3; ++k) out.linear[r][c] += parent.linear[r][k] * m[k][c];
        }
        out.offset[r] = parent.offset[r];
        for (int k = 0; k < 3; ++k) out.offset[r] += parent.linear[r][k] * m[k][3];
    }
    return out;
}

Vec3d to_vec(const aiVector3D& v) {
    return {v.x, v.y, v.z};
}

std::uint8_t byte_of(float value) {
    return byte_of_unit(static_cast<double>(value));
}

class SceneMerger {
 public:
    SceneMerger(const aiScene& scene, const fs::path& path, const MeshReadLimits& limits, ImportedMesh& out)
        : scene_(scene), path_(path), limits_(limits), finder_(path, limits.asset_roots), out_(out) {
        for (unsigned k = 0; k < scene.mNumMeshes; ++k) {
            const aiMesh& mesh = *scene.mMeshes[k];
            has_uvs_ = has_uvs_ || mesh.HasTextureCoords(0);
            has_normals_ = has_normals_ || mesh.HasNormals();
            has_colours_ = has_colours_ || mesh.HasVertexColors(0);
        }
    }

    void run() {
        for (unsigned k = 0; k < scene_.mNumMaterials; ++k)
            out_.mesh.materials.push_back(convert(*scene_.mMaterials[k]));
        // Depth first in the file's order, without recursion: hierarchies may be as deep as a file is long.
        struct Entry {
            const aiNode* node;
            Placement parent;
        };
        std::vector<Entry> stack{{scene_.mRootNode, world()}};
        while (!stack.empty()) {
            const Entry entry = stack.back();
            stack.pop_back();
            const Placement placement = entry.parent * entry.node->mTransformation;
            for (unsigned k = 0; k < entry.node->mNumMeshes; ++k) {
                const unsigned mesh = entry.node->mMeshes[k];
                if (mesh < scene_.mNumMeshes) append(*scene_.mMeshes[mesh], placement);
            }
            for (unsigned k = entry.node->mNumChildren; k > 0; --k)
                stack.push_back({entry.node->mChildren[k - 1], placement});
        }
        if (fans_ > 0) warn(std::to_string(fans_) + " polygons are flat or cross themselves and were split as fans");
        if (not_triangles_ > 0) out_.dropped.emplace_back("lines and points", not_triangles_);
        if (bad_faces_ > 0) out_.dropped.emplace_back("faces with vertices that do not exist", bad_faces_);
    }

 private:
    /// assimp 5.2 leaves FBX in its own units and axes and tells what they are.
    Placement world() {
        Placement out;
        double centimetres = 0;
        if (!number_of("UnitScaleFactor", centimetres) || !std::isfinite(centimetres) || !(centimetres > 0)) return out;
        const double scale = centimetres / 100;
        const std::array<std::array<const char*, 2>, 3> keys{
            {{"CoordAxis", "CoordAxisSign"}, {"UpAxis", "UpAxisSign"}, {"FrontAxis", "FrontAxisSign"}}};
        Placement axes;
        bool stated = true;
        for (int row = 0; row < 3; ++row) {
            double axis = 0, sign = 0;
            stated = stated && number_of(keys[row][0], axis) && number_of(keys[row][1], sign) && axis >= 0 && axis <= 2;
            for (int column = 0; column < 3; ++column)
                axes.linear[row][column] = stated && column == static_cast<int>(axis) ? (sign < 0 ? -1 : 1) : 0;
        }
        if (stated && axes.is_rotation()) {
            out = axes;
            if (out.linear[1][1] != 1) out_.remarks.emplace_back("FBX with another axis up: turned to y up");
        }
        for (auto& row : out.linear)
            for (double& value : row) value *= scale;
        std::array<char, 64> text{};
        static_cast<void>(
            std::snprintf(text.data(), text.size(), "FBX unit of %g cm: scaled by %g to metres", centimetres, scale));
        if (scale != 1) out_.remarks.emplace_back(text.data());
        return out;
    }

    /// A number of the scene's metadata, of whatever type. @return false if there is none of that name
    bool number_of(const char* key, double& out) const {
        if (scene_.mMetaData == nullptr) return false;
        float single = 0;
        std::int32_t whole = 0;
        if (scene_.mMetaData->Get(key, out)) return true;
        if (scene_.mMetaData->Get(key, single))
            out = static_cast<double>(single);
        else if (scene_.mMetaData->Get(key, whole))
            out = whole;
        else
            return false;
        return true;
    }

    void append(const aiMesh& source, const Placement& placement) {
        auto& mesh = out_.mesh;
        const std::uint64_t vertices = mesh.positions.size() + std::uint64_t{source.mNumVertices};
        const std::uint64_t faces = mesh.faces.size() + std::uint64_t{source.mNumFaces};
        if (vertices > limits_.max_vertices || faces > limits_.max_faces)
            throw model::Error(codes::kTooLarge,
                               "more than " + std::to_string(limits_.max_faces) + " faces or " +
                                   std::to_string(limits_.max_vertices) + " vertices",
                               path_.string());
        const auto base = static_cast<std::uint32_t>(mesh.positions.size());
        for (unsigned k = 0; k < source.mNumVertices; ++k)
            mesh.positions.push_back(placement.point(to_vec(source.mVertices[k])));
        const bool mirrors = placement.mirrors();
        for (unsigned f = 0; f < source.mNumFaces; ++f) {
            const std::span<const unsigned> face(source.mFaces[f].mIndices, source.mFaces[f].mNumIndices);
            if (face.size() < 3) {
                ++not_triangles_;
                continue;
            }
            if (*std::max_element(face.begin(), face.end()) >= source.mNumVertices) {
                ++bad_faces_;
                continue;
            }
            split(face, source);
            for (const CornerTriple& triple : triples_) {
                std::array<unsigned, 3> index{face[triple[0]], face[triple[1]], face[triple[2]]};
                if (mirrors) std::swap(index[1], index[2]);
                mesh.faces.push_back({base + index[0], base + index[1], base + index[2]});
                mesh.face_materials.push_back(source.mMaterialIndex);
                for (const unsigned k : index) append_corner(source, k, placement);
            }
        }
    }

    /// Makes triples_ of a polygon's corners. assimp has split all polygons but where some are large.
    void split(std::span<const unsigned> face, const aiMesh& source) {
        triples_.clear();
        loop_.clear();
        for (const unsigned k : face) loop_.push_back(to_vec(source.mVertices[k]));
        if (!triangulate_polygon(loop_, triples_, budget_)) ++fans_;
        if (budget_.is_crossed()) throw crossed_polygons(path_.string());
    }

    void append_corner(const aiMesh& source, unsigned k, const Placement& placement) {
        auto& mesh = out_.mesh;
        if (has_normals_)
            mesh.corner_normals.push_back(source.HasNormals() ? placement.normal(to_vec(source.mNormals[k])) : Vec3d{});
        if (has_uvs_) {
            const bool present = source.HasTextureCoords(0);
            mesh.corner_uvs.push_back(
                present ? model::Vec2d{source.mTextureCoords[0][k].x, source.mTextureCoords[0][k].y} : model::Vec2d{});
        }
        if (has_colours_) {
            const bool present = source.HasVertexColors(0);
            const aiColor4D c = present ? source.mColors[0][k] : aiColor4D(1, 1, 1, 1);
            mesh.corner_colours.push_back({byte_of(c.r), byte_of(c.g), byte_of(c.b), byte_of(c.a)});
        }
    }

    model::Material convert(const aiMaterial& source) {
        model::Material out;
        aiString name;
        if (source.Get(AI_MATKEY_NAME, name) == aiReturn_SUCCESS) out.name = name.C_Str();
        aiColor4D colour(1, 1, 1, 1);
        if (source.Get(AI_MATKEY_BASE_COLOR, colour) != aiReturn_SUCCESS) source.Get(AI_MATKEY_COLOR_DIFFUSE, colour);
        float opacity = 1;
        source.Get(AI_MATKEY_OPACITY, opacity);
        // A wholly invisible material would not be in the file: exporters that mean "opaque" write 0 there.
        if (!(opacity > 0)) opacity = 1;
        out.diffuse = {byte_of(colour.r), byte_of(colour.g), byte_of(colour.b), byte_of(opacity)};
        out.diffuse_map = texture(source, aiTextureType_BASE_COLOR);
        if (out.diffuse_map.empty()) out.diffuse_map = texture(source, aiTextureType_DIFFUSE);
        out.bump_map = texture(source, aiTextureType_HEIGHT);
        if (!out.bump_map.empty()) {
            out.bump_is_normal_map = is_normal_map_name(out.bump_map.path);
        } else {
            out.bump_map = texture(source, aiTextureType_NORMALS);
            out.bump_is_normal_map = !out.bump_map.empty();
        }
        float bump_scale = 1;
        source.Get(AI_MATKEY_BUMPSCALING, bump_scale);
        if (std::isfinite(bump_scale)) out.bump_scale = static_cast<double>(bump_scale);
        return out;
    }

    model::PictureFile texture(const aiMaterial& material, aiTextureType type) {
        aiString file;
        if (material.GetTexture(type, 0, &file) != aiReturn_SUCCESS || file.length == 0) return {};
        const std::string_view name(file.C_Str());
        if (const auto [inside, index] = scene_.GetEmbeddedTextureAndIndex(file.C_Str()); inside != nullptr)
            return embedded(*inside, static_cast<std::size_t>(index));
        const FoundFile found = finder_.find(name);
        if (found) {
            out_.dependencies.push_back(*found);
            return {*found};
        }
        out_.missing.emplace_back(name);
        warn(texture_missing(name, found.why));
        return {};
    }

    /// A picture inside the mesh's file. Materials that share it share its bytes.
    model::PictureFile embedded(const aiTexture& picture, std::size_t index) {
        std::string name = picture.mFilename.length > 0 ? picture.mFilename.C_Str() : "";
        if (name.empty()) name = "picture " + std::to_string(index + 1);
        name += " in " + path_.filename().string();
        if (picture.mHeight != 0 || picture.pcData == nullptr) {
            warn("texture of bare pixels is not used: " + name);
            return {};
        }
        pictures_.resize(scene_.mNumTextures);
        if (!pictures_[index])
            pictures_[index] = std::make_shared<const std::string>(reinterpret_cast<const char*>(picture.pcData),
                                                                   std::size_t{picture.mWidth});
        return {name, pictures_[index]};
    }

    void warn(std::string text) {
        if (std::find(out_.warnings.begin(), out_.warnings.end(), text) == out_.warnings.end())
            out_.warnings.push_back(std::move(text));
    }

    const aiScene& scene_;
    const fs::path& path_;
    const MeshReadLimits& limits_;
    FileFinder finder_;
    ImportedMesh& out_;
    std::vector<std::shared_ptr<const std::string>> pictures_;  ///< of the scene, once a material names them
    bool has_uvs_ = false, has_normals_ = false, has_colours_ = false;
    std::uint64_t not_triangles_ = 0, bad_faces_ = 0, fans_ = 0;
    PolygonBudget budget_;
    std::vector<Vec3d> loop_;  ///< of one polygon, like the next
    std::vector<CornerTriple> triples_;
};

/// assimp takes a time that grows with the square of a polygon's corners, and more.
constexpr unsigned kLargestForAssimp = 256;

unsigned largest_polygon(const aiScene& scene) {
    unsigned most = 0;
    for (const aiMesh* mesh : std::span(scene.mMeshes, scene.mNumMeshes))
        for (const aiFace& face : std::span(mesh->mFaces, mesh->mNumFaces)) most = std::max(most, face.mNumIndices);
    return most;
}

/// Leaves the importers of the file's extension, or for an unknown one those of the formats that a folder search takes:
/// the others have no business with a stranger's bytes.
void drop_importers(Assimp::Importer& importer, const fs::path& path) {
    const std::string extension = lower_case(path.extension().string());
    const bool is_known = importer.IsExtensionSupported(extension);
    for (std::size_t k = importer.GetImporterCount(); k-- > 0;) {
        Assimp::BaseImporter* one = importer.GetImporter(k);
        std::set<std::string> extensions;
        one->GetExtensionList(extensions);
        const bool wanted = std::any_of(extensions.begin(), extensions.end(), [&](const std::string& its) {
            return is_known ? "." + its == extension : has_mesh_extension("x." + its);
        });
        if (!wanted && importer.UnregisterLoader(one) == aiReturn_SUCCESS) delete one;
    }
}

/// The error of a mesh that needs a file which it may not name.
model::Error refusal(const fs::path& file, const fs::path& mesh) {
    const fs::path relative = file.lexically_relative(mesh.parent_path());
    const std::string name = relative.empty() ? file.string() : relative.string();
    if (is_special_file(file)) return {codes::kReferenceNoFile, "it needs " + name, mesh.string()};
    return {codes::kReferenceOutside, "it needs " + name, mesh.string()};
}

}  // namespace

ImportedMesh read_with_assimp(const fs::path& path, const MeshReadLimits& limits) {
    ImportedMesh out;
    OpenedFiles files;
    Assimp::Importer importer;
    importer.SetIOHandler(new GuardedIo(path, limits.asset_roots, limits.max_file_bytes, files));  // it owns it
    drop_importers(importer, path);
    // Degenerate and invalid data stay in: repair counts what it drops. assimp computes no normals either.
    const aiScene* scene = nullptr;
    try {
        scene = importer.ReadFile(path.string(), aiProcess_TransformUVCoords);
        if (scene != nullptr && largest_polygon(*scene) <= kLargestForAssimp)
            scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
    } catch (const std::exception& e) {
        if (files.trouble) throw model::Error(*files.trouble);
        if (!files.refused.empty()) throw refusal(files.refused.front(), path);
        throw model::Error(codes::kImportFailed, std::string("assimp: ") + e.what(), path.string());
    }
    if (files.trouble) throw model::Error(*files.trouble);
    if (!files.refused.empty()) throw refusal(files.refused.front(), path);
    if (scene == nullptr || scene->mRootNode == nullptr)
        throw model::Error(codes::kImportFailed, std::string("assimp: ") + importer.GetErrorString(), path.string());
    SceneMerger(*scene, path, limits, out).run();
    if (out.mesh.faces.empty())
        throw model::Error(codes::kNoFaces, "no usable faces in " + std::to_string(scene->mNumMeshes) + " meshes",
                           path.string());
    const fs::path self = path.lexically_normal();
    for (const fs::path& file : files.opened)
        if (file.lexically_normal() != self) out.dependencies.push_back(file);
    std::sort(out.dependencies.begin(), out.dependencies.end());
    out.dependencies.erase(std::unique(out.dependencies.begin(), out.dependencies.end()), out.dependencies.end());
    return out;
}

bool assimp_knows_extension(const std::string& extension) {
    if (extension.empty()) return false;
    return Assimp::Importer().IsExtensionSupported(extension);
}

}  // namespace dgm::formats
