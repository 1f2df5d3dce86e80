#include "apps/charts/svg_drawing.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>

namespace cosplat {
namespace {

std::string SvgAttribute(const std::string& name, const std::string& value) {
  return " " + name + "=\"" + value + "\"";
}
std::string SvgAttribute(const std::string& name, double px) {
  return SvgAttribute(name, SvgNumber(px));
}

std::string AnchorAttribute(SvgAnchor anchor) {
  if (anchor == SvgAnchor::kMiddle) return SvgAttribute("text-anchor", "middle");
  if (anchor == SvgAnchor::kEnd) return SvgAttribute("text-anchor", "end");
  return "";
}

std::string TextElement(double x,
                        double y,
                        const std::string& text,
                        const std::string& attributes) {
  return "<text" + SvgAttribute("x", x) + SvgAttribute("y", y) + attributes + ">" +
         EscapeXml(text) + "</text>\n";
}

std::string LineElement(double x0, double y0, double x1, double y1, const std::string& attributes) {
  return "<line" + SvgAttribute("x1", x0) + SvgAttribute("y1", y0) + SvgAttribute("x2", x1) +
         SvgAttribute("y2", y1) + attributes + "/>\n";
}

std::string CircleElement(double x, double y, double radius, const std::string& attributes) {
  return "<circle" + SvgAttribute("cx", x) + SvgAttribute("cy", y) + SvgAttribute("r", radius) +
         attributes + "/>\n";
}

}  // namespace

std::string SvgNumber(double px) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", px);
  return text;
}

double Overlap(const SvgBox& a, const SvgBox& b) {
  const double w = std::min(a.right, b.right) - std::max(a.left, b.left);
  const double h = std::min(a.bottom, b.bottom) - std::max(a.top, b.top);
  return w > 0 && h > 0 ? w * h : 0;
}

double SvgTextWidth(const std::string& text) {
  constexpr double kMeanWidth = 0.56;  // of a character, in units of the font size
  size_t characters = 0;
  for (const char c : text) characters += (uint8_t(c) & 0xc0) != 0x80;  // not a UTF-8 continuation
  return kMeanWidth * kSvgFont * double(characters);
}

std::string EscapeXml(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

void SvgDrawing::Title(double x, double y, const std::string& text) {
  body_ +=
      TextElement(x, y, text, SvgAttribute("font-weight", "bold") + SvgAttribute("font-size", 15));
}

void SvgDrawing::Text(double x, double y, const std::string& text, SvgAnchor anchor) {
  body_ += TextElement(x, y, text, AnchorAttribute(anchor));
}

void SvgDrawing::Label(
    double x, double y, const std::string& text, const std::string& color, SvgAnchor anchor) {
  body_ += TextElement(x,
                       y,
                       text,
                       AnchorAttribute(anchor) + SvgAttribute("fill", color) +
                           SvgAttribute("stroke", "#ffffff") + SvgAttribute("stroke-width", 3) +
                           SvgAttribute("paint-order", "stroke"));
}

void SvgDrawing::UprightText(double x, double y, const std::string& text) {
  body_ += TextElement(
      x,
      y,
      text,
      AnchorAttribute(SvgAnchor::kMiddle) +
          SvgAttribute("transform", "rotate(-90 " + SvgNumber(x) + " " + SvgNumber(y) + ")"));
}

void SvgDrawing::Line(double x0, double y0, double x1, double y1, const std::string& color) {
  body_ += LineElement(x0, y0, x1, y1, SvgAttribute("stroke", color));
}

void SvgDrawing::DashedLine(double x0, double y0, double x1, double y1, const std::string& color) {
  body_ += LineElement(
      x0, y0, x1, y1, SvgAttribute("stroke", color) + SvgAttribute("stroke-dasharray", "6 5"));
}

void SvgDrawing::Rectangle(
    double x, double y, double width, double height, const std::string& color) {
  body_ += "<rect" + SvgAttribute("x", x) + SvgAttribute("y", y) + SvgAttribute("width", width) +
           SvgAttribute("height", height) + SvgAttribute("fill", color) + "/>\n";
}

void SvgDrawing::Dot(double x, double y, const std::string& color) {
  body_ += CircleElement(x, y, 4, SvgAttribute("fill", color));
}

void SvgDrawing::HollowDot(double x, double y, const std::string& color) {
  body_ += CircleElement(x,
                         y,
                         3.3,
                         SvgAttribute("fill", "#ffffff") + SvgAttribute("stroke", color) +
                             SvgAttribute("stroke-width", 2));
}

void SvgDrawing::Ring(double x, double y, const std::string& color) {
  body_ += CircleElement(x, y, 7, SvgAttribute("fill", "none") + SvgAttribute("stroke", color));
}

void SvgDrawing::Path(const std::string& points, const std::string& color) {
  body_ += "<polyline" + SvgAttribute("points", points) + SvgAttribute("fill", "none") +
           SvgAttribute("stroke", color) + SvgAttribute("stroke-width", 2) + "/>\n";
}

std::string SvgDrawing::Finish() const {
  const std::string size = SvgAttribute("width", width_) + SvgAttribute("height", height_);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\"" +
         SvgAttribute("viewBox", "0 0 " + SvgNumber(width_) + " " + SvgNumber(height_)) + size +
         SvgAttribute("font-family", "system-ui,sans-serif") + SvgAttribute("font-size", kSvgFont) +
         SvgAttribute("fill", "#222222") + ">\n<rect" + size + SvgAttribute("fill", "#ffffff") +
         "/>\n" + body_ + "</svg>\n";
}

}  // namespace cosplat
