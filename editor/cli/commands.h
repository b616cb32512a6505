#pragma once

// The subcommands of the furrow tool. Each adds itself to the command line and runs when it was chosen;
// faults are thrown as pipeline::Error.

#include <CLI/CLI.hpp>
#include <functional>
#include <limits>
#include <string>

namespace furrow::cli {

using Command = std::function<void()>;

// Whether a number can be a float: no NaN, which CLI::Range lets through, and none that becomes infinite.
inline bool isFloat(double value) {
  return value >= std::numeric_limits<float>::lowest() && value <= std::numeric_limits<float>::max();
}

// The same as a check of an option.
inline std::string requireFloat(const std::string& text) {
  double value = 0.0;
  return !CLI::detail::lexical_cast(text, value) || isFloat(value) ? std::string()
                                                                   : text + " is no number to work with";
}

inline std::string requirePositive(const std::string& text) {
  double value = 0.0;
  return CLI::detail::lexical_cast(text, value) && isFloat(value) && value > 0.0 ? std::string()
                                                                                 : text + " is not above 0";
}

// What is written appears whole or not at all, so not on standard output.
inline std::string requireName(const std::string& text) {
  return text == "-" ? "- is no name of a file: give one, or /dev/stdout for standard output" : std::string();
}

// Adds the subcommand to `app`; what it returns runs the command with the parsed options.
Command addCook(CLI::App& app);
Command addInfo(CLI::App& app);
Command addCheck(CLI::App& app);
Command addEval(CLI::App& app);
Command addRender(CLI::App& app);
Command addBind(CLI::App& app);
Command addExport(CLI::App& app);

}  // namespace furrow::cli
