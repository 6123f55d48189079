// Handled errors for a terminal.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "report/values/handled_error.hpp"

namespace report {
namespace {

std::string at(const Time& time) { return fmt::format("{:.4f} s", seconds(time)); }

std::string in_words(const HandledError& error) {
  std::string text =
      fmt::format("  {}: {}{} {}\n", error.robot, error.origin, error.of.empty() ? "" : ",", fmt::join(error.of, ", "));
  if (text.ends_with(" \n")) text.erase(text.size() - 2, 1);
  text += error.happened ? fmt::format("    happened at {} ({}), noticed at {}\n", at(*error.happened), error.because,
                                       at(error.noticed))
                         : fmt::format("    noticed at {}\n", at(error.noticed));
  if (error.decided)
    text += fmt::format("    decided at {}: {}; {}\n", at(*error.decided), error.response,
                        error.done      ? "done at " + at(*error.done)
                        : error.cleared ? "not done before it was cleared"
                                        : "not done by the end");
  else
    text += "    no DSP has decided what to do\n";
  text += fmt::format(
      "    the load moved {:.3f} m until the error was noticed, {}at most {:.3f} m\n", error.moved_until_noticed_m,
      error.moved_until_done_m ? fmt::format("{:.3f} m until the response was done, ", *error.moved_until_done_m) : "",
      error.moved_most_m);
  if (error.cleared)
    text += fmt::format("    cleared by the operator at {}\n", at(*error.cleared));
  else if (error.stands)
    text += "    NOT CLEARED: the robot waits for the operator (errors.clear)\n";
  return text;
}

}  // namespace

std::string errors_text(const std::vector<HandledError>& errors) {
  if (errors.empty()) return "";
  std::string text = fmt::format("\nErrors: {}\n", errors.size());
  for (const HandledError& error : errors) text += in_words(error);
  return text;
}

}  // namespace report
