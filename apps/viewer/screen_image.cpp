#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/viewer/key_bindings.h"
#include "apps/viewer/screen.h"
#include "apps/viewer/surface_buffer.h"

namespace cosplat::viewer {
namespace {

constexpr float kOrbitPerHeight = 3.14159265f;  // radians for a drag over the image height
constexpr ImGuiWindowFlags kImageWindow = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove |
                                          ImGuiWindowFlags_NoSavedSettings |
                                          ImGuiWindowFlags_NoBringToFrontOnFocus;

void MoveCamera(OrbitCamera& camera, const ScreenRect& place, ScreenResult& result) {
  const ImGuiIO& io = ImGui::GetIO();
  if (ImGui::IsItemHovered() && io.MouseWheel != 0) {
    camera.Zoom(io.MouseWheel);
    result.dragging = true;
  }
  if (!ImGui::IsItemActive()) return;
  result.dragging = true;
  const float x = io.MouseDelta.x / place.height, y = io.MouseDelta.y / place.height;
  if (ImGui::IsMouseDown(ImGuiMouseButton_Left) && !io.KeyShift) {
    camera.Orbit(-x * kOrbitPerHeight, y * kOrbitPerHeight);
  } else {
    camera.Pan(x, y);
  }
}

void DrawCheckers(ImDrawList& list, ImVec2 from, ImVec2 to, float side) {
  list.AddRectFilled(from, to, IM_COL32(200, 200, 200, 255));
  for (int row = 0; from.y + float(row) * side < to.y; ++row)
    for (int column = row % 2; from.x + float(column) * side < to.x; column += 2) {
      const ImVec2 a{from.x + float(column) * side, from.y + float(row) * side};
      list.AddRectFilled(a,
                         {std::min(a.x + side, to.x), std::min(a.y + side, to.y)},
                         IM_COL32(150, 150, 150, 255));
    }
}

// As large as fits, centred.
void DrawTexture(const Session& session, const ScreenState& state, const ScreenRect& place) {
  if (state.texture == 0) return;
  const float fit = std::min(place.width / float(state.width), place.height / float(state.height));
  const ImVec2 size{fit * float(state.width), fit * float(state.height)};
  const ImVec2 from{place.x + (place.width - size.x) / 2, place.y + (place.height - size.y) / 2};
  const ImVec2 to{from.x + size.x, from.y + size.y};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (session.transparent) DrawCheckers(list, from, to, 14 * state.scale);
  list.AddImage(ImTextureID(state.texture), from, to);  // a pointer before 1.91, then a number
}

// Text on a dark background. Returns its height.
float DrawLabel(ImVec2 at, const char* text, float scale, ImU32 color) {
  const ImVec2 size = ImGui::CalcTextSize(text);
  const float pad = 6 * scale;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 to{at.x + size.x + 2 * pad, at.y + size.y + 2 * pad};
  list.AddRectFilled(at, to, IM_COL32(20, 22, 26, 230), 4 * scale);
  list.AddText({at.x + pad, at.y + pad}, color, text);
  return size.y + 2 * pad;
}

void DrawLegend(const Session& session, float scale, const ScreenRect& place) {
  const int max = session.max_per_face();
  const float letters = ImGui::GetTextLineHeight(), row = letters + 4 * scale;
  std::vector<int> counts;  // `max` and the powers of two below it
  for (int count = 1; count < max; count *= 2) counts.push_back(count);
  counts.push_back(max);
  std::reverse(counts.begin(), counts.end());
  counts.push_back(0);
  const char* title = "Gaussians per triangle";
  const ImVec2 size{ImGui::CalcTextSize(title).x + 20 * scale,
                    row * float(counts.size() + 1) + 14 * scale};
  const ImVec2 at{place.x + 12 * scale, place.y + place.height - size.y - 12 * scale};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  list.AddRectFilled(at, {at.x + size.x, at.y + size.y}, IM_COL32(20, 22, 26, 230), 4 * scale);
  ImVec2 pen{at.x + 10 * scale, at.y + 7 * scale};
  list.AddText(pen, IM_COL32_WHITE, title);
  for (const int count : counts) {
    pen.y += row;
    const Rgb c = count > 0 ? ScaleColor(CountPlace(count, max)) : kNoneColor;
    list.AddRectFilled(
        pen, {pen.x + 2 * letters, pen.y + letters}, IM_COL32(c[0], c[1], c[2], 255));
    char text[16];
    std::snprintf(text, sizeof text, "%d", count);
    list.AddText({pen.x + 2 * letters + 8 * scale, pen.y}, IM_COL32_WHITE, text);
  }
}

void DrawLabels(const Session& session, const ScreenState& state, const ScreenRect& place) {
  const float scale = state.scale, left = place.x + 12 * scale;
  float top = place.y + 12 * scale;
  const auto label = [&](const char* text, ImU32 color) {
    top += DrawLabel({left, top}, text, scale, color) + 6 * scale;
  };
  if (state.recorded_seconds >= 0) {
    char text[48];
    std::snprintf(text, sizeof text, "Recording %.1f s", state.recorded_seconds);
    label(text, IM_COL32(255, 120, 110, 255));
  }
  if (!state.notice.empty())
    label(state.notice.c_str(),
          state.notice_is_problem ? IM_COL32(255, 170, 120, 255) : IM_COL32(200, 230, 255, 255));
  if (session.view() == View::kTriangles) DrawLegend(session, scale, place);
}

}  // namespace

void DrawImage(Session& session, const ScreenState& state, ScreenRect place, ScreenResult& result) {
  ImGui::SetNextWindowPos({place.x, place.y});
  ImGui::SetNextWindowSize({place.width, place.height});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, {0.07f, 0.07f, 0.08f, 1});
  ImGui::Begin("image", nullptr, kImageWindow);
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
  ImGui::InvisibleButton("hand",
                         {std::max(place.width, 1.0f), std::max(place.height, 1.0f)},
                         ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                             ImGuiButtonFlags_MouseButtonMiddle);
  MoveCamera(session.camera, place, result);
  DrawTexture(session, state, place);
  DrawLabels(session, state, place);
  ImGui::End();
}

void DrawHelp(bool& open, float scale) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({size.x / 2, size.y / 2}, ImGuiCond_Appearing, {0.5f, 0.5f});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, 6 * scale);
  ImGui::Begin("Keys and mouse",
               &open,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse |
                   ImGuiWindowFlags_NoSavedSettings);
  ImGui::PopStyleVar();
  const auto line = [scale](const char* key, const char* text) {
    ImGui::TextColored({0.55f, 0.8f, 1, 1}, "%s", key);
    ImGui::SameLine(150 * scale);
    ImGui::TextUnformatted(text);
  };
  line("Left drag", "circle");
  line("Right drag", "shift (also Shift and left, or the middle button)");
  line("Wheel", "nearer, farther");
  line("Ctrl click", "on a slider: type a number");
  ImGui::Separator();
  for (const KeyBinding& binding : KeyBindings()) line(binding.label, binding.text);
  ImGui::End();
}

}  // namespace cosplat::viewer
