#include "editor/ui/headless_screen.h"

#include <epoxy/gl.h>
#include <imgui.h>
#include <imgui_impl_opengl3.h>

#include <algorithm>

#include "editor/preview/gl_objects.h"
#include "editor/ui/widgets.h"

namespace furrow::editor::ui {

using preview::GlKind;
using preview::GlObject;

struct HeadlessScreen::State {
  int width, height;
  GlObject texture{GlKind::kTexture}, frame{GlKind::kFramebuffer};
};

void setUpImgui() {
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = io.LogFilename = nullptr;
  io.ConfigFlags |= ImGuiConfigFlags_NavEnableKeyboard;
  constexpr std::pair<ImGuiKey, int> kKeys[] = {{ImGuiKey_Tab, key::kTab},
                                                {ImGuiKey_LeftArrow, key::kLeft},
                                                {ImGuiKey_RightArrow, key::kRight},
                                                {ImGuiKey_UpArrow, key::kUp},
                                                {ImGuiKey_DownArrow, key::kDown},
                                                {ImGuiKey_PageUp, key::kPageUp},
                                                {ImGuiKey_Home, key::kHome},
                                                {ImGuiKey_PageDown, key::kPageDown},
                                                {ImGuiKey_End, key::kEnd},
                                                {ImGuiKey_Insert, key::kInsert},
                                                {ImGuiKey_Backspace, key::kBackspace},
                                                {ImGuiKey_Delete, key::kDelete},
                                                {ImGuiKey_Space, key::kSpace},
                                                {ImGuiKey_Enter, key::kEnter},
                                                {ImGuiKey_Escape, key::kEscape},
                                                {ImGuiKey_A, 'A'},
                                                {ImGuiKey_C, 'C'},
                                                {ImGuiKey_V, 'V'},
                                                {ImGuiKey_X, 'X'},
                                                {ImGuiKey_Y, 'Y'},
                                                {ImGuiKey_Z, 'Z'}};
  for (const auto& [imgui, index] : kKeys) io.KeyMap[imgui] = index;
}

HeadlessScreen::HeadlessScreen(int width, int height, float scale) {
  ImGui::CreateContext();
  setUpImgui();
  applyTheme(scale);
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
  ImGui_ImplOpenGL3_Init("#version 330 core");
  state_ = std::make_unique<State>(State{width, height});
  glBindTexture(GL_TEXTURE_2D, state_->texture);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glBindFramebuffer(GL_FRAMEBUFFER, state_->frame);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, state_->texture, 0);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

HeadlessScreen::~HeadlessScreen() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext();
}

Screen HeadlessScreen::screen() {
  Screen screen;
  screen.begin = [] {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
  };
  screen.end = [this] {
    ImGui::Render();
    glBindFramebuffer(GL_FRAMEBUFFER, state_->frame);
    glViewport(0, 0, state_->width, state_->height);
    glClearColor(0.08f, 0.08f, 0.085f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
  };
  screen.picture = [this] {
    const auto width = static_cast<uint32_t>(state_->width), height = static_cast<uint32_t>(state_->height);
    pipeline::ByteImage bytes{width, height, 4, std::vector<uint8_t>(size_t{4} * width * height)};
    glBindFramebuffer(GL_READ_FRAMEBUFFER, state_->frame);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, state_->width, state_->height, GL_RGBA, GL_UNSIGNED_BYTE, bytes.pixels.data());
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    for (size_t i = 3; i < bytes.pixels.size(); i += 4) bytes.pixels[i] = 255;
    const size_t row = size_t{4} * width;
    for (uint32_t y = 0; y < height / 2; ++y)
      std::swap_ranges(&bytes.pixels[y * row], &bytes.pixels[y * row] + row,
                       &bytes.pixels[(height - 1 - y) * row]);
    return pipeline::toFloats(bytes);
  };
  return screen;
}

}  // namespace furrow::editor::ui
