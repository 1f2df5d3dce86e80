// Material of the procedural head at each point of its rest shape: colour, gloss, hair.
//
// Everything is a function of the point on the rest surface, so the paint moves with the mesh.
// Albedos are linear RGB; features are wider than half a pixel of the demonstration video.
#pragma once

#include "assets/head/mesh.h"

namespace cosplat::procedural {

struct Material {
  Vec albedo{};
  float specular = 0;    // strength of the highlight
  float shininess = 20;  // Blinn-Phong exponent
  float hair = 0;        // 1: shaded as strands along `flow`
  Vec flow{};            // direction of the strands at rest, unit
};

// A point of the head component with interpolated labels (4 / -4 where there is no ring).
struct PaintSite {
  Vec rest{};
  Vec normal{};
  float mouth = -4;
  float lid = 4;
  float along = 0;
  float upper = 0;
  float ear = -1;
};

Material PaintHead(const PaintSite& site);

// Parts of PaintHead.
void PaintFace(const PaintSite& site, Material& material);
void PaintHair(const PaintSite& site, Material& material);
void PaintBrow(const PaintSite& site, Material& material);
void PaintShirt(const PaintSite& site, Material& material);
Material PaintMouthInside(const PaintSite& site);

// `direction`: from the eyeball's centre in its own frame (iris at +z), unit length; `left` varies
// the veins.
Material PaintEye(const Vec& direction, bool left);

}  // namespace cosplat::procedural
