#include "assets/head/shading.h"

#include <algorithm>
#include <cmath>

#include "assets/head/paint.h"
#include "assets/head/sculpt.h"

namespace cosplat::procedural {
namespace {

struct Light {
  Vec direction{};  // towards the light
  Vec color{};
  float highlight;
};
// Large soft boxes: key light from the subject's upper left, fill from the right, a weak one
// behind.
const Light kLights[] = {
    {Normalize(Vec{0.42f, 0.50f, 0.76f}), {0.80f, 0.75f, 0.70f}, 1.0f},
    {Normalize(Vec{-0.72f, 0.12f, 0.62f}), {0.24f, 0.26f, 0.30f}, 0.45f},
    {Normalize(Vec{-0.55f, 0.45f, -0.70f}), {0.26f, 0.28f, 0.32f}, 0.7f},
};
constexpr Vec kSky{0.36f, 0.37f, 0.40f};
constexpr Vec kGround{0.22f, 0.19f, 0.17f};
// Subsurface light wraps around the terminator, red the farthest.
constexpr Vec kWrap{0.45f, 0.30f, 0.24f};

// sRGB's transfer function as a table: pow is the most expensive part of shading.
class Encoder {
 public:
  Encoder() {
    for (int i = 0; i <= kSteps; ++i) {
      const float x = float(i) / kSteps;
      table_[i] = x <= 0.0031308f ? 12.92f * x : 1.055f * std::pow(x, 1 / 2.4f) - 0.055f;
    }
  }
  float operator()(float x) const {
    const float at = std::clamp(x, 0.0f, 1.0f) * kSteps;
    const int i = std::min(int(at), kSteps - 1);
    return table_[i] + (at - float(i)) * (table_[i + 1] - table_[i]);
  }

 private:
  static constexpr int kSteps = 4096;
  float table_[kSteps + 1];
};

std::array<float, 3> Encode(const Vec& linear) {
  static const Encoder encoder;
  auto tone = [](float x) { return x < 0.6f ? x : 0.6f + 0.4f * std::tanh((x - 0.6f) / 0.4f); };
  return {encoder(tone(linear.x)), encoder(tone(linear.y)), encoder(tone(linear.z))};
}

float Wrapped(float cosine, float wrap) { return std::max(0.0f, (cosine + wrap) / (1 + wrap)); }

// Specular highlight: Blinn-Phong with Schlick's Fresnel term, normalised for energy.
float SurfaceHighlight(const Vec& n, const Vec& l, const Vec& v, float shininess) {
  const Vec h = Normalize(l + v);
  const float facing = Dot(n, h);
  if (facing <= 0.5f || Dot(n, l) <= 0) return 0;  // pow(0.5, any skin's shininess) is negligible
  const float m = 1 - std::max(Dot(v, h), 0.0f);
  const float fresnel = 0.35f + 0.65f * m * m * m;
  return fresnel * (shininess + 8) * 0.06f * std::pow(facing, shininess) *
         std::min(1.0f, 4 * Dot(n, l));
}

// Highlight of strands along t: bright if the half vector is perpendicular to them (Kajiya and Kay
// 1989).
float StrandHighlight(const Vec& n, const Vec& t, const Vec& l, const Vec& v, float shininess) {
  const Vec h = Normalize(l + v);
  const float along = Dot(t, h);
  const float across = std::sqrt(std::max(0.0f, 1 - along * along));
  return 0.9f * std::pow(across, 2 * shininess) * Wrapped(Dot(n, l), 0.3f);
}

Vec Illuminate(const Material& m, const Vec& n, const Vec& flow, const Vec& v, float occlusion) {
  const float open = Mix(0.45f, 1.0f, occlusion);  // every fold sees part of the soft boxes
  Vec diffuse = Mix(kGround, kSky, 0.5f + 0.5f * n.y) * occlusion;
  Vec highlight{};
  for (const Light& light : kLights) {
    const float c = Dot(n, light.direction);
    const Vec wrapped{Wrapped(c, kWrap.x), Wrapped(c, kWrap.y), Wrapped(c, kWrap.z)};
    diffuse += light.color * wrapped * open;
    float shine = (1 - m.hair) * SurfaceHighlight(n, light.direction, v, m.shininess);
    if (m.hair > 0) shine += m.hair * StrandHighlight(n, flow, light.direction, v, m.shininess);
    highlight += light.color * (light.highlight * m.specular * shine * open);
  }
  const float grazing = 1 - std::max(Dot(n, v), 0.0f);
  highlight += kSky * (0.25f * m.specular * grazing * grazing * grazing * occlusion);
  return m.albedo * diffuse + highlight;
}

// Share of the light that reaches a ring inside the mouth.
float MouthOpenness(float ring) {
  static constexpr float kAt[] = {0.40f, 0.26f, 0.50f, 0.80f, 0.30f, 0.12f, 0.02f};  // rings 3..9
  const float at = std::clamp(ring - 3, 0.0f, 5.999f);
  const int i = int(at);
  return Mix(kAt[i], kAt[i + 1], at - float(i));
}

}  // namespace

HeadShader::HeadShader(const ProceduralHead& head, const ShadedPose& pose, const Vec& eye)
    : head_(head),
      pose_(pose),
      eye_(eye),
      normals_(VertexNormals(pose.vertices, head.mesh.faces)),
      rest_normals_(VertexNormals(head.mesh.positions, head.mesh.faces)) {
  std::array<float, 2> count{};
  for (size_t v = 0; v < pose.vertices.size(); ++v) {
    const Part part = head.mesh.labels[v].part;
    if (part != Part::kLeftEye && part != Part::kRightEye) continue;
    const int side = part == Part::kLeftEye ? 0 : 1;
    eye_centers_[side] += pose.vertices[v];
    count[side] += 1;
  }
  for (int side = 0; side < 2; ++side) eye_centers_[side] = eye_centers_[side] * (1 / count[side]);
}

HeadShader::Corner HeadShader::Interpolate(const SurfacePoint& point) const {
  Corner c{};
  const auto& face = head_.mesh.faces[point.face];
  for (int k = 0; k < 3; ++k) {
    const int v = face[k];
    const float b = point.barycentrics[k];
    const VertexLabel& l = head_.mesh.labels[v];
    c.rest += b * head_.mesh.positions[v];
    c.rest_normal += b * rest_normals_[v];
    c.normal += b * normals_[v];
    c.position += b * pose_.vertices[v];
    c.occlusion += b * head_.ambient_occlusion[v];
    c.mouth += b * (l.mouth_ring == kNoRing ? -4.0f : float(l.mouth_ring));
    c.lid += b * (l.lid_ring == kNoRing ? 4.0f : float(l.lid_ring));
    c.along += b * l.along;
    c.upper += b * l.upper;
    c.ear += b * (l.ear_ring == kNoRing ? -1.0f : float(l.ear_ring));
  }
  c.normal = Normalize(c.normal);
  c.rest_normal = Normalize(c.rest_normal);
  return c;
}

// Shadow of the upper lid and its lashes on the eyeball, from the current opening of the lids.
float HeadShader::LidShadow(const Vec& position, bool left) const {
  const Vec d = TransposeTimes(pose_.posed_from_rest, position - eye_centers_[left ? 0 : 1]);
  const EyeAngles a = AnglesAroundEye(left, EyeCenter(left) + d);
  const float along = std::clamp((a.azimuth + 3) / 65, -1.0f, 1.0f);
  const float blink = std::clamp(left ? pose_.blink_left : pose_.blink_right, 0.0f, 1.0f);
  const float upper = Mix(UpperLidElevation(along), ClosedLidElevation(along), blink);
  const float lower = Mix(LowerLidElevation(along), ClosedLidElevation(along), blink);
  const float below = upper - a.elevation, above = a.elevation - lower;
  const float corner = 1 - 0.45f * SmoothStep(0.55f, 1.0f, std::abs(along));
  return corner * (0.42f + 0.58f * SmoothStep(-2, 13, below)) *
         (0.75f + 0.25f * SmoothStep(-2, 6, above));
}

std::array<float, 3> HeadShader::ShadeEye(const Corner& c, bool left) const {
  const Vec d = Normalize(c.rest - EyeCenter(left));
  const Material m = PaintEye(d, left);
  const Vec v = Normalize(eye_ - c.position);
  return Encode(Illuminate(m, c.normal, {}, v, 1) * LidShadow(c.position, left));
}

std::array<float, 3> HeadShader::Shade(const SurfacePoint& point) const {
  const Corner c = Interpolate(point);
  if (point.back)
    return Encode(c.rest.y < -0.10f ? Vec{0.010f, 0.016f, 0.026f} : Vec{0.012f, 0.003f, 0.003f});
  const Part part = head_.mesh.labels[head_.mesh.faces[point.face][0]].part;
  if (part == Part::kLeftEye || part == Part::kRightEye) return ShadeEye(c, part == Part::kLeftEye);
  const PaintSite site{c.rest, c.rest_normal, c.mouth, c.lid, c.along, c.upper, c.ear};
  const Material m = PaintHead(site);
  const Vec v = Normalize(eye_ - c.position);
  float occlusion = c.occlusion;
  if (c.lid < -1) occlusion *= std::max(0.2f, 1 + 0.5f * (c.lid + 1));
  const Vec color =
      Illuminate(m, c.normal, m.hair > 0 ? pose_.posed_from_rest * m.flow : Vec{}, v, occlusion);
  return Encode(c.mouth > 3 ? color * MouthOpenness(c.mouth) : color);
}

}  // namespace cosplat::procedural
