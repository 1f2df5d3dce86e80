// The shapes that charts are made of, as SVG text. Lengths in px, from the top left.
#pragma once

#include <string>

namespace cosplat {

constexpr double kSvgFont = 13;

struct SvgBox {
  double left = 0, top = 0, right = 0, bottom = 0;
};
// Area that both cover.
double Overlap(const SvgBox& a, const SvgBox& b);

// About the width that UTF-8 text takes in a sans-serif font of kSvgFont.
double SvgTextWidth(const std::string& text);

// Text as XML and HTML have it.
std::string EscapeXml(const std::string& text);

enum class SvgAnchor { kStart, kMiddle, kEnd };

class SvgDrawing {
 public:
  SvgDrawing(double width, double height) : width_(width), height_(height) {}

  void Title(double x, double y, const std::string& text);
  void Text(double x, double y, const std::string& text, SvgAnchor anchor = SvgAnchor::kStart);
  // With a white seam, for text that lies on lines.
  void Label(double x,
             double y,
             const std::string& text,
             const std::string& color,
             SvgAnchor anchor = SvgAnchor::kStart);
  // From bottom to top, centred at (x, y).
  void UprightText(double x, double y, const std::string& text);
  void Line(double x0, double y0, double x1, double y1, const std::string& color);
  void DashedLine(double x0, double y0, double x1, double y1, const std::string& color);
  void Rectangle(double x, double y, double width, double height, const std::string& color);
  void Dot(double x, double y, const std::string& color);
  void HollowDot(double x, double y, const std::string& color);
  void Ring(double x, double y, const std::string& color);
  // "x,y x,y ..."
  void Path(const std::string& points, const std::string& color);

  // The whole file, on white.
  std::string Finish() const;

 private:
  double width_, height_;
  std::string body_;
};

// One decimal, as everything in the file.
std::string SvgNumber(double px);

}  // namespace cosplat
