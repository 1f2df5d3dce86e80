// The only file that includes tinygltf.
#include <tiny_gltf.h>

#include <algorithm>
#include <exception>
#include <limits>

#include "splat/base/compression.h"
#include "splat/base/error.h"
#include "splat/base/files.h"
#include "splat/base/text.h"
#include "splat/io/glb.h"

namespace cosplat {
namespace {

tinygltf::Value ToValue(const Json& json) {
  if (json.is_boolean()) return tinygltf::Value(json.get<bool>());
  if (json.is_number_integer()) return tinygltf::Value(json.get<int>());
  if (json.is_number()) return tinygltf::Value(json.get<double>());
  if (json.is_string()) return tinygltf::Value(json.get<std::string>());
  if (json.is_array()) {
    tinygltf::Value::Array array;
    for (const Json& element : json) array.push_back(ToValue(element));
    return tinygltf::Value(std::move(array));
  }
  tinygltf::Value::Object object;
  for (const auto& [key, value] : json.items()) object[key] = ToValue(value);
  return tinygltf::Value(std::move(object));
}

// Minimum and maximum of each component, which glTF requires for positions.
void AddBounds(const GlbDocument& document,
               const GlbAccessor& accessor,
               tinygltf::Accessor& out,
               int index) {
  const auto values =
      ReadValues<float>(document, index, accessor.width, Format("accessors[{}]", index));
  out.minValues.assign(values.begin(), values.begin() + accessor.width);
  out.maxValues = out.minValues;
  for (size_t i = 0; i < values.size(); ++i) {
    double &min = out.minValues[i % accessor.width], &max = out.maxValues[i % accessor.width];
    min = std::min(min, double(values[i]));
    max = std::max(max, double(values[i]));
  }
}

// Each accessor has its own buffer view.
void AddAccessors(const GlbDocument& document, tinygltf::Model& model) {
  constexpr std::array<int, 5> kTypes{
      0, TINYGLTF_TYPE_SCALAR, TINYGLTF_TYPE_VEC2, TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4};
  for (const GlbAccessor& accessor : document.accessors) {
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = accessor.offset;
    view.byteLength = accessor.count * accessor.stride;
    view.target = accessor.use == GlbUse::kData      ? 0
                  : accessor.use == GlbUse::kIndices ? TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER
                                                     : TINYGLTF_TARGET_ARRAY_BUFFER;
    tinygltf::Accessor out;
    out.bufferView = int(model.bufferViews.size());
    out.componentType = accessor.component;
    out.type = kTypes[accessor.width];
    out.count = accessor.count;
    if (accessor.use == GlbUse::kPosition)
      AddBounds(document, accessor, out, int(model.accessors.size()));
    model.bufferViews.push_back(std::move(view));
    model.accessors.push_back(std::move(out));
  }
}

tinygltf::Primitive ToTinygltf(const GlbPrimitive& primitive) {
  tinygltf::Primitive out;
  out.mode = primitive.mode;
  out.attributes = primitive.attributes;
  out.indices = primitive.indices;
  out.targets = primitive.targets;
  for (const auto& [name, extension] : primitive.extensions.items())
    out.extensions[name] = ToValue(extension);
  return out;
}

tinygltf::Model ToTinygltf(const GlbDocument& document) {
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "CoSplat";
  model.extensionsUsed = document.extensions_used;
  model.buffers.resize(1);
  model.buffers[0].data = document.binary;
  AddAccessors(document, model);
  for (const GlbMesh& mesh : document.meshes) {
    tinygltf::Mesh out;
    out.name = mesh.name;
    for (const GlbPrimitive& primitive : mesh.primitives)
      out.primitives.push_back(ToTinygltf(primitive));
    if (!mesh.extras.is_null()) out.extras = ToValue(mesh.extras);
    model.meshes.push_back(std::move(out));
  }
  for (const GlbScene& scene : document.scenes) {
    tinygltf::Scene out;
    out.name = scene.name;
    for (int mesh : scene.meshes) {
      out.nodes.push_back(int(model.nodes.size()));
      model.nodes.emplace_back();
      model.nodes.back().mesh = mesh;
      model.nodes.back().name = document.meshes[mesh].name;
      const std::array<double, 3>& translation = document.meshes[mesh].translation;
      if (translation != std::array<double, 3>{})
        model.nodes.back().translation = {translation.begin(), translation.end()};
    }
    model.scenes.push_back(std::move(out));
  }
  model.defaultScene = 0;
  return model;
}

GlbMesh FromTinygltf(const tinygltf::Mesh& mesh) {
  GlbMesh out;
  out.name = mesh.name;
  for (const tinygltf::Primitive& primitive : mesh.primitives) {
    GlbPrimitive p;
    p.mode = primitive.mode;
    p.attributes = primitive.attributes;
    p.indices = primitive.indices;
    p.targets = primitive.targets;
    // Parses the text, since tinygltf's values keep 32 bits of an integer and drop empty values.
    if (!primitive.extensions_json_string.empty())
      p.extensions = Json::parse(primitive.extensions_json_string);
    out.primitives.push_back(std::move(p));
  }
  return out;
}

// `model` has passed CheckGlb.
GlbAccessor FromTinygltf(const tinygltf::Model& model, const tinygltf::Accessor& accessor) {
  const tinygltf::BufferView& view = model.bufferViews[accessor.bufferView];
  GlbAccessor out;
  out.component = accessor.componentType;
  out.width = tinygltf::GetNumComponentsInType(uint32_t(accessor.type));
  out.count = accessor.count;
  out.offset = view.byteOffset + accessor.byteOffset;
  out.stride = size_t(accessor.ByteStride(view));
  return out;
}

bool HasTransform(const tinygltf::Node& node) {
  const auto differs = [](const std::vector<double>& values, const std::vector<double>& none) {
    return !values.empty() && values != none;
  };
  return differs(node.translation, {0, 0, 0}) || differs(node.rotation, {0, 0, 0, 1}) ||
         differs(node.scale, {1, 1, 1}) ||
         differs(node.matrix, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
}

// Images are not needed, and decoding them is the most vulnerable part of a glTF library.
bool IgnoreImage(
    tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*, int, void*) {
  return true;
}

tinygltf::Model Load(const std::string& path, const std::vector<char>& bytes) {
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(IgnoreImage, nullptr);
  loader.SetStoreOriginalJSONForExtrasAndExtensions(true);
  tinygltf::Model model;
  std::string error, warning;
  if (loader.LoadBinaryFromMemory(&model,
                                  &error,
                                  &warning,
                                  reinterpret_cast<const unsigned char*>(bytes.data()),
                                  unsigned(bytes.size())))
    return model;
  std::replace(error.begin(), error.end(), '\n', ' ');
  throw Error(path, "is not a usable glTF file: " + error);
}

}  // namespace

void WriteGlb(const GlbDocument& document) {
  // Leaves room below the limit for the JSON, which takes some 300 bytes per accessor.
  constexpr size_t kMaxBinary = 0xFF000000;
  if (document.binary.size() > kMaxBinary)
    throw Error(document.path,
                "",
                "would need " + std::to_string(document.binary.size()) +
                    " bytes, but a .glb is limited to 4 GiB");
  const tinygltf::Model model = ToTinygltf(document);
  WriteFileAtomically(document.path, [&](std::ostream& out) {
    constexpr bool kPretty = false, kBinary = true;
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, out, kPretty, kBinary))
      throw Error(document.path, "could not be written as glTF");
  });
}

GlbDocument ReadGlb(const std::string& path, const std::vector<std::string>& known_extensions) {
  return ParseGlb(path, ReadUnpacked(path), known_extensions);
}

GlbDocument ParseGlb(const std::string& path,
                     const std::vector<char>& bytes,
                     const std::vector<std::string>& known_extensions) {
  CheckGlb(path, bytes, known_extensions);
  try {
    tinygltf::Model model = Load(path, bytes);
    GlbDocument document;
    document.path = path;
    document.extensions_used = model.extensionsUsed;
    for (const auto& accessor : model.accessors)
      document.accessors.push_back(FromTinygltf(model, accessor));
    for (const auto& mesh : model.meshes) document.meshes.push_back(FromTinygltf(mesh));
    document.has_transforms = std::any_of(model.nodes.begin(), model.nodes.end(), HasTransform);
    for (const auto& node : model.nodes)
      if (node.mesh >= 0 && size_t(node.mesh) < document.meshes.size() &&
          node.translation.size() == 3 && node.rotation.empty() && node.scale.empty())
        std::copy_n(node.translation.begin(), 3, document.meshes[node.mesh].translation.begin());
    if (!model.buffers.empty()) document.binary = std::move(model.buffers[0].data);
    return document;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(path, std::string("is not a usable glTF file: ") + error.what());
  }
}

}  // namespace cosplat
