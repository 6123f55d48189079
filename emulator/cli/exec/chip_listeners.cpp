#include "cli/exec/chip_listeners.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "c40/observers/profile.hpp"
#include "c40/observers/self_check.hpp"
#include "c40/peripherals/register_map.hpp"
#include "c40/pipeline/pipeline_diagram.hpp"
#include "io/output_file.hpp"
#include "isa/ascii.hpp"
#include "machine/program_text/instruction_trace.hpp"
#include "machine/program_text/profile.hpp"
#include "report/events/trace_text.hpp"

namespace cli {
namespace {

using toolchain::Address;
using toolchain::Image;
using toolchain::Word;
using Json = nlohmann::ordered_json;

/// FIRST:LAST, in cycles.
c40::PipelineDiagram parse_window(const std::string& text, const Image& image, c40::TraceSink* next) {
  const auto parts = ascii::split(text, ':');
  const auto first = ascii::number<c40::Cycles>(parts.front()), last = ascii::number<c40::Cycles>(parts.back());
  if (parts.size() != 2 || !first || !last)
    throw InputError(fmt::format("--pipeline: \"{}\" is not FIRST:LAST, two numbers of cycles", text));
  try {
    const auto name = [names = machine::AddressNames(image)](Address address) {
      return names.name(address).value_or("");
    };
    return {*first, *last,
            [text = machine::SourceText(image, machine::SourceText::Label::kept), name](Address address, Word word) {
              return text(address, word, name);
            },
            next};
  } catch (const std::invalid_argument& error) {
    throw InputError(fmt::format("--pipeline: {}", error.what()));
  }
}

}  // namespace

/// Each part may be absent.
struct ChipListeners::Parts {
  Parts(const c40::Chip& chip_, const Image& image_) : chip(chip_), image(image_), entry(chip_.pc()) {}
  const c40::Chip& chip;
  const Image& image;
  Address entry;
  std::optional<io::OutputFile> file;
  std::optional<machine::InstructionText> trace;
  std::optional<c40::SelfCheck> check;
  c40::ProfileCounts counts;
  std::optional<c40::Profile> profile;
  std::optional<c40::PipelineDiagram> pipeline;
  c40::TraceSink* first = nullptr;  ///< each passes events to the one before

  std::string profile_report(bool json) const {
    c40::Causes outside = chip.causes();
    const c40::Causes instructions = counts.total().causes;
    for (std::size_t i = 0; i < outside.size(); ++i) outside[i] -= instructions[i];
    const report::Profile whole = machine::empty_profile();
    const report::ProfileGroup group = machine::profile_group(counts, outside, {entry}, image, true);
    return json ? to_json(whole, group) : to_text(whole, group);
  }
};

ChipListeners::ChipListeners(const c40::Chip& chip, const Image& image, const ExecOptions& options, unsigned number,
                             const std::optional<std::string>& trace)
    : parts_(std::make_unique<Parts>(chip, image)) {
  Parts& p = *parts_;
  if (trace) {
    p.file.emplace(*trace);
    p.file->stream() << (options.trace_labels ? report::labelled_trace_header : report::instruction_trace_header)
                     << '\n';
    p.first = &p.trace.emplace(
        number, [&p](const std::string& line) { p.file->stream() << line << '\n'; }, machine::InstructionText::Wanted{},
        options.trace_labels ? std::optional(machine::Labels::of_program(image)) : std::nullopt);
  }
  if (options.check) p.first = &p.check.emplace(chip, p.first);
  if (options.profile) p.first = &p.profile.emplace(p.counts, p.first);
  if (options.pipeline) p.first = &p.pipeline.emplace(parse_window(*options.pipeline, image, p.first));
}

ChipListeners::~ChipListeners() = default;

c40::TraceSink* ChipListeners::sink() const { return parts_->first; }

void ChipListeners::run_ended() {
  if (parts_->check) parts_->check->run_ended();
  if (parts_->file) parts_->file->commit_or_note();
}

std::string ChipListeners::checks_text() const {
  if (!parts_->check) return {};
  const std::vector<c40::Diagnostic>& all = parts_->check->diagnostics();
  std::string out =
      fmt::format("checks: {}\n", all.empty() ? "no rule was broken" : fmt::format("{} found", all.size()));
  for (const c40::Diagnostic& found : all)
    out += fmt::format("  {:08X}  {}\n    {} ({} {}): {}; cycle {}{}\n", found.pc, found.instruction, name(found.rule),
                       c40::document(found.rule), found.section, found.message, found.cycle,
                       found.count > 1 ? fmt::format(", {} times", found.count) : "");
  return out;
}

std::string ChipListeners::text() const {
  return (parts_->profile ? parts_->profile_report(false) : "") + (parts_->pipeline ? parts_->pipeline->text() : "");
}

void ChipListeners::add_to(Json& out) const {
  if (parts_->check) {
    out["diagnostics"] = Json::array();
    for (const c40::Diagnostic& found : parts_->check->diagnostics())
      out["diagnostics"].push_back({{"rule", name(found.rule)},
                                    {"section", found.section},
                                    {"pc", found.pc},
                                    {"cycle", found.cycle},
                                    {"instruction", found.instruction},
                                    {"message", found.message},
                                    {"count", found.count}});
  }
  if (parts_->profile) out["profile"] = Json::parse(parts_->profile_report(true));
  if (parts_->pipeline) out["pipeline"] = parts_->pipeline->text();
}

// ---- peripherals ----

namespace {

bool is_fifo(const c40::RegisterInfo& info) {
  return c40::is_port_register(info.address) &&
         c40::port_access(info.address, false, 0, 0).reg != c40::PortRegister::control;
}

std::vector<Word> words_of(const c40::Fifo& fifo) { return {fifo.words().begin(), fifo.words().end()}; }

}  // namespace

std::string peripherals_text(const c40::Chip& chip) {
  std::string out;
  for (const c40::RegisterInfo& info : c40::register_map()) {
    if (is_fifo(info)) continue;
    const Word value = chip.peripheral(info.name);
    if (value == info.reset) continue;
    std::string fields;
    for (const c40::Field& field : info.fields)
      if (field.in(value)) fields += fmt::format("  {}={}", field.name, field.of(value));
    out += fmt::format("{:<22}{:08X}{}\n", info.name, value, fields);
  }
  for (int n = 0; n < c40::port_count; ++n) {
    const c40::CommPort& port = chip.port(n);
    for (const auto& [name, fifo] : {std::pair{"input", &port.input}, std::pair{"output", &port.output}})
      if (!fifo->empty()) out += fmt::format("PORT{}.{:<16}{:08X}\n", n, name, fmt::join(fifo->words(), " "));
  }
  return out;
}

void add_peripherals(const c40::Chip& chip, Json& out) {
  Json& all = out["peripherals"] = Json::object();
  for (const c40::RegisterInfo& info : c40::register_map()) {
    if (is_fifo(info)) continue;
    const Word value = chip.peripheral(info.name);
    Json& reg = all[info.name] = {{"value", value}};
    for (const c40::Field& field : info.fields) reg["fields"][std::string(field.name)] = field.of(value);
  }
}

void add_ports(const c40::Chip& chip, Json& out) {
  out["ports"] = Json::array();
  for (int n = 0; n < c40::port_count; ++n) {
    const c40::CommPort& port = chip.port(n);
    out["ports"].push_back({{"control", port.control()},
                            {"input", words_of(port.input)},
                            {"output", words_of(port.output)},
                            {"written", port.traffic.written},
                            {"sent", port.traffic.sent},
                            {"received", port.traffic.received},
                            {"read", port.traffic.read},
                            {"discarded_output", port.traffic.discarded_output},
                            {"discarded_input", port.traffic.discarded_input}});
  }
}

void add_reserved(const machine::IgnoredAccesses& ignored, nlohmann::ordered_json& out) {
  if (ignored.empty()) return;
  auto& root = out["reserved"];
  root = {{"accesses", ignored.count()}, {"addresses", nlohmann::ordered_json::array()}};
  for (const auto& note : ignored.notes())
    root["addresses"].push_back(
        {{"address", note.address},
         {"reads", note.reads},
         {"writes", note.writes},
         {"first", note.write ? "write" : "read"},
         {"value", note.value},
         {"pc", note.pc},
         {"cycle", note.cycle},
         {"dma_channel", note.channel < 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(note.channel)}});
}

}  // namespace cli
