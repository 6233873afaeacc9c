#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <imgui.h>

// Texts, tables and choices of the panel.
namespace slipstream::view {

inline const ImVec4 white(1, 1, 1, 1), quiet(0.62F, 0.66F, 0.72F, 1), bad(1.0F, 0.50F, 0.42F, 1),
    doubtful(1.0F, 0.78F, 0.36F, 1), good(0.50F, 0.85F, 0.55F, 1), primary(0.16F, 0.42F, 0.72F, 1),
    saturated_ink(1.0F, 0.42F, 0.40F, 1), too_dark_ink(0.50F, 0.65F, 1.0F, 1);

/// Writes a text of that colour, on as many lines as it takes.
template <class... Values>
void say(const ImVec4& colour, fmt::format_string<Values...> format, Values&&... values) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::TextWrapped("%s", fmt::format(format, std::forward<Values>(values)...).c_str());
  ImGui::PopStyleColor();
}

/// Draws a heading that opens and closes its part of the panel; returns whether it is open.
bool section(const char* name);

/// Writes the name of a field at the left, and places the field, of the rest of the width, beside
/// it. Give the field the label "##NAME".
void name_field(const char* name);

/// A large button across the panel.
bool large_button(const char* name);

/// Explains the item drawn last while the mouse is on it, beside the panel, where it covers no
/// message.
void tell_help(const char* help);

/// Draws a row of a table with two columns.
void row(const char* name, const std::string& value, const ImVec4& colour = white);

/// Calls `draw_rows` within a table, unless it is scrolled out of view.
template <class DrawRows>
void table(const char* name, int columns, ImGuiTableFlags flags, const DrawRows& draw_rows) {
  if (!ImGui::BeginTable(name, columns, flags)) return;

  draw_rows();
  ImGui::EndTable();
}

/// The label of a field whose name is at its left.
inline std::string hidden_label(const std::string& name) {
  return "##" + name;
}

/// A drop-down of names; returns whether the choice changed.
template <class Number>
bool choose(const char* label, const std::vector<const char*>& names, Number& chosen) {
  int number = static_cast<int>(chosen);
  name_field(label);
  ImGui::Combo(hidden_label(label).c_str(), &number, names.data(), static_cast<int>(names.size()));

  const bool changed = number != static_cast<int>(chosen);
  chosen = static_cast<Number>(number);
  return changed;
}

/// A drop-down of labelled choices, if there are several.
template <class Choices>
bool choose_labelled(const char* label, const Choices& choices, std::size_t& chosen) {
  if (choices.size() < 2 || chosen >= choices.size()) return false;

  std::vector<const char*> names;
  for (const auto& choice : choices) names.push_back(choice.first.c_str());
  return choose(label, names, chosen);
}

}  // namespace slipstream::view
