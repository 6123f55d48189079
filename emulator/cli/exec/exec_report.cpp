// The result of exec for one chip, as text and as JSON.
#include "cli/exec/exec_report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "c40/values/float40.hpp"
#include "cli/arguments/program.hpp"
#include "io/print.hpp"
#include "isa/ascii.hpp"
#include "isa/types.hpp"

namespace cli {

using isa::Register;
using toolchain::Address;
using toolchain::Image;

namespace {

double microseconds(const c40::Chip& chip, double clock_mhz) {
  return static_cast<double>(chip.cycle()) * 2.0 / clock_mhz;
}

std::string register_name(Register reg) { return ascii::upper(isa::name(reg)); }

/// Exact, because a register's mantissa fits into a double.
constexpr std::array<Register, isa::register_count> all_registers() {
  using enum Register;
  return {R0,  R1,  R2,  R3,  R4, R5,  R6,  R7, R8, R9, R10, R11, AR0, AR1, AR2, AR3,
          AR4, AR5, AR6, AR7, DP, IR0, IR1, BK, SP, ST, DIE, IIE, IIF, RS,  RE,  RC};
}

}  // namespace

/// ADDRESS:COUNT
std::pair<Address, Address> parse_dump(const std::string& text, const Image& image) {
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos) throw InputError(fmt::format("--dump: \"{}\" is not ADDRESS:COUNT", text));
  const Address address = parse_address(std::string_view(text).substr(0, colon), &image, "--dump");
  const Address count = parse_address(std::string_view(text).substr(colon + 1), nullptr, "--dump, COUNT");
  if (count == 0 || count > 1'000'000)
    throw InputError(fmt::format("--dump: {} words; 1 to 1000000 are possible", count));
  return {address, count};
}

Dump read_dump(const c40::Chip& chip, Address address, Address count, std::string_view what) {
  Dump dump{address, {}};
  for (Address i = 0; i < count; ++i) {
    try {
      dump.words.push_back(chip.peek(address + i));
    } catch (const std::out_of_range&) {
      throw InputError(fmt::format("{}: {:08X}h is no memory of this board", what, address + i));
    }
  }
  return dump;
}

void print_text(const ExecReport& report) {
  const c40::Chip& chip = report.chip;
  io::print("{}", report.front.text());
  io::print("stop: {}: {}\n", report.outcome.reason, report.outcome.message);
  io::print("PC {:08X}  {} instructions, {} cycles\n", chip.pc(), chip.instructions(), chip.cycle());
  for (std::size_t cause = 0; cause < c40::cause_count; ++cause)
    if (chip.causes()[cause] != 0)
      io::print("  {:<18}{:>14}\n", name(static_cast<c40::Cause>(cause)), chip.causes()[cause]);
  if (report.clock_mhz) io::print("  {:.3f} us at {} MHz\n", microseconds(chip, *report.clock_mhz), *report.clock_mhz);
  io::print("{}", report.listeners.checks_text());
  int column = 0;
  for (const Register reg : all_registers()) {
    if (isa::is_extended(reg)) {
      io::print("{:<4}{:010X}  {:.9g}\n", register_name(reg), chip.register_value(reg),
                c40::float40::to_double(chip.float_register(reg)));
      continue;
    }
    io::print("{:<4}{:08X}{}", register_name(reg), chip.register_value(reg), ++column % 5 == 0 ? "\n" : "   ");
  }
  io::print("IVTP {:08X}  TVTP {:08X}\n", chip.expansion(isa::Expansion::IVTP), chip.expansion(isa::Expansion::TVTP));
  for (const Dump& dump : report.dumps)
    for (std::size_t i = 0; i < dump.words.size(); ++i) {
      if (i % 8 == 0) io::print("{}{:08X}:", i == 0 ? "" : "\n", dump.address + i);
      io::print(" {:08X}{}", dump.words[i], i + 1 == dump.words.size() ? "\n" : "");
    }
  io::print("{}", report.listeners.text());
  if (report.peripherals) io::print("{}", peripherals_text(chip));
  io::print("{}{}", report.ignored.text(), report.front.hash_text());
}

void print_json(const ExecReport& report) {
  const c40::Chip& chip = report.chip;
  using Json = nlohmann::ordered_json;
  Json root = {{"stop", {{"reason", report.outcome.reason}, {"message", report.outcome.message}, {"pc", chip.pc()}}},
               {"instructions", chip.instructions()},
               {"cycles", chip.cycle()}};
  for (std::size_t cause = 0; cause < c40::cause_count; ++cause)
    root["causes"][std::string(name(static_cast<c40::Cause>(cause)))] = chip.causes()[cause];
  for (const Register reg : all_registers()) {
    root["registers"][register_name(reg)] = chip.register_value(reg);
    if (isa::is_extended(reg)) root["floats"][register_name(reg)] = c40::float40::to_double(chip.float_register(reg));
  }
  root["registers"]["IVTP"] = chip.expansion(isa::Expansion::IVTP);
  root["registers"]["TVTP"] = chip.expansion(isa::Expansion::TVTP);
  if (report.clock_mhz) root["microseconds"] = microseconds(chip, *report.clock_mhz);
  root["dumps"] = Json::array();
  for (const Dump& dump : report.dumps) root["dumps"].push_back({{"address", dump.address}, {"words", dump.words}});
  report.listeners.add_to(root);
  if (report.peripherals) {
    add_peripherals(chip, root);
    add_ports(chip, root);
  }
  report.front.add_to(root);
  add_reserved(report.ignored, root);
  io::print("{}\n", root.dump(2, ' ', true, Json::error_handler_t::replace));
}

}  // namespace cli
