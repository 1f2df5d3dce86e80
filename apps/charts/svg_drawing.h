// The shapes of a chart as SVG text. Lengths in px, from the top left corner.
#pragma once

#include <string>

namespace cosplat {

constexpr double kSvgFont = 13;

struct SvgBox {
  double left = 0, top = 0, right = 0, bottom = 0;
};
// Area of the intersection.
double Overlap(const SvgBox& a, const SvgBox& b);

// Approximate width of UTF-8 text in a sans-serif font of size kSvgFont.
double SvgTextWidth(const std::string& text);

// Escapes text for XML and HTML.
std::string EscapeXml(const std::string& text);

enum class SvgAnchor { kStart, kMiddle, kEnd };

class SvgDrawing {
 public:
  SvgDrawing(double width, double height) : width_(width), height_(height) {}

  void Title(double x, double y, const std::string& text);
  void Text(double x, double y, const std::string& text, SvgAnchor anchor = SvgAnchor::kStart);
  // With a white outline, for text drawn on lines.
  void Label(double x,
             double y,
             const std::string& text,
             const std::string& color,
             SvgAnchor anchor = SvgAnchor::kStart);
  // Reads from bottom to top, centred at (x, y).
  void UprightText(double x, double y, const std::string& text);
  void Line(double x0, double y0, double x1, double y1, const std::string& color);
  void DashedLine(double x0, double y0, double x1, double y1, const std::string& color);
  void Rectangle(double x, double y, double width, double height, const std::string& color);
  void Dot(double x, double y, const std::string& color);
  void HollowDot(double x, double y, const std::string& color);
  void Ring(double x, double y, const std::string& color);
  // "x,y x,y ..."
  void Path(const std::string& points, const std::string& color);

  // The whole file, on a white background.
  std::string Finish() const;

 private:
  double width_, height_;
  std::string body_;
};

// One decimal, as all numbers in the file.
std::string SvgNumber(double px);

}  // namespace cosplat
