// What the procedural head is made of at each point of its rest shape: colour, gloss, hair.
//
// Everything is a function of the point on the rest surface, so paint sticks to the mesh exactly.
// Albedos are linear RGB; features are kept wider than half a pixel of the demonstration video.
#pragma once

#include "assets/head/mesh.h"

namespace cosplat::procedural {

struct Material {
  Vec albedo;
  float specular = 0;    // strength of the highlight
  float shininess = 20;  // its Blinn-Phong exponent
  float hair = 0;        // 1: lit as strands along `flow`
  Vec flow;              // direction of the strands at rest, unit
};

// A point of the head's component, labels interpolated (4 / -4 where there is no ring).
struct PaintSite {
  Vec rest;
  Vec normal;
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

// Direction from the eyeball's centre in its own frame (iris at +z), unit; `left` varies the veins.
Material PaintEye(const Vec& direction, bool left);

}  // namespace cosplat::procedural
