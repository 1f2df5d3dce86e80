#include "apps/viewer/screen.h"

#include <imgui.h>

#include <filesystem>

#include "apps/viewer/key_bindings.h"

namespace cosplat::viewer {
namespace {

// At scale 1.
constexpr float kPanelWidth = 330, kTimelineHeight = 46, kLetterHeight = 15;
// From Debian's fonts-dejavu-core; ImGui's built-in font is small and coarse.
constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

void PressKeys(Session& session, const ScreenState& state, ScreenResult& result) {
  if (ImGui::GetIO().WantTextInput) return;
  for (const KeyPress& press : state.pressed)
    for (const KeyBinding& binding : KeyBindings()) {
      if (binding.key != press.key || (press.is_repeat && !binding.repeats)) continue;
      session.Do(binding.action);
      result.actions.push_back(binding.action);
    }
}

}  // namespace

ScreenResult DrawScreen(Session& session, const ScreenState& state) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ScreenResult result;
  PressKeys(session, state, result);
  const float panel = session.panels_open ? kPanelWidth * state.scale : 0;
  const float bar =
      session.panels_open && session.has_sequence() ? kTimelineHeight * state.scale : 0;
  const ScreenRect image{0, 0, size.x - panel, size.y - bar};
  DrawImage(session, state, image, result);
  if (panel > 0) DrawPanels(session, state, {size.x - panel, 0, panel, size.y}, result);
  if (bar > 0) DrawTimeline(session, {0, size.y - bar, size.x - panel, bar});
  if (session.help_open) DrawHelp(session.help_open, state.scale);
  const ImVec2 pixels = ImGui::GetIO().DisplayFramebufferScale;
  result.width = int(image.width * pixels.x);
  result.height = int(image.height * pixels.y);
  return result;
}

void SetUpStyle(float scale) {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = style.ChildRounding = 0;
  style.FrameRounding = style.GrabRounding = style.PopupRounding = 4;
  style.WindowBorderSize = 0;
  style.WindowPadding = {12, 10};
  style.FramePadding = {8, 4};
  style.ItemSpacing = {8, 6};
  style.GrabMinSize = 12;
  style.Colors[ImGuiCol_WindowBg] = {0.11f, 0.12f, 0.14f, 1};
  style.Colors[ImGuiCol_FrameBg] = {0.19f, 0.21f, 0.24f, 1};
  style.Colors[ImGuiCol_PlotLines] = {0.45f, 0.75f, 1, 1};
  style.ScaleAllSizes(scale);
  ImFontConfig config;
  config.SizePixels = kLetterHeight * scale;
  ImFontAtlas& fonts = *ImGui::GetIO().Fonts;
  if (std::filesystem::exists(kFont)) {
    fonts.AddFontFromFileTTF(kFont, config.SizePixels);
  } else {
    fonts.AddFontDefault(&config);
  }
}

}  // namespace cosplat::viewer
