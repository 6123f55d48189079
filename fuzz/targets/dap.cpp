// The Debug Adapter Protocol: bytes as a stream of messages, and lines as messages to a session with a small program.
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "debugger/dap_session.hpp"
#include "debugger/dap_stream.hpp"
#include "fuzz/target.hpp"
#include "machine/debug/network_debuggee.hpp"
#include "machine/networks/network.hpp"
#include "toolchain/assembler/assembler.hpp"

namespace {

using debugger::dap::Json;

const std::shared_ptr<const toolchain::Image>& program() {
  static const auto image = std::make_shared<const toolchain::Image>(toolchain::assemble_text(
      "        .text\nstart:  ldp total\n        ldi 3,r0\nloop:   addi @total,r0\n        sti r0,@total\n        subi "
      "1,r1\n        cmpi -9,r1\n        bnz loop\nend:    b end\ntotal:  .word 1\n",
      "small.asm"));
  return image;
}

struct Small {
  static machine::NetworkDescription description() {
    machine::NetworkDescription one;
    machine::NetworkChip chip;
    chip.program = program();
    // Few words: the debugger saves them all again and again.
    chip.board.board.regions = {{"local", 0x300000, 0x400, 0, 0, c40::Region::Kind::ram, c40::Region::Bus::local}};
    one.chips.push_back(std::move(chip));
    return one;
  }
  machine::Network network{description()};
  machine::debug::NetworkDebuggee debuggee{network};
};

/// Any bytes give messages, and a reported end.
void frame(std::string_view bytes) {
  debugger::dap::Framing framing;
  fuzz::done<debugger::dap::BrokenStream>([&] {
    for (std::size_t at = 0, piece = 1; at < bytes.size(); at += piece, piece = piece % 7 + 1) {
      framing.add(bytes.substr(at, piece));
      while (const auto message = framing.next())
        fuzz::expect(message->size() <= debugger::dap::Framing::longest_message, "a message beyond the limit");
    }
  });
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t most = 8192, most_messages = 40;
  if (size > most) return 0;
  fuzz::Input input(data, size);
  const std::string_view text = input.text();
  frame(text);
  std::size_t answers = 0;
  debugger::dap::Session session(
      [&](const Json& message) {
        answers += message.at("type") == "response";
        fuzz::expect(!debugger::dap::framed(message).empty(), "an answer that cannot be sent");
      },
      [](const Json&) {
        auto small = std::make_shared<Small>();
        return debugger::dap::Launched{small, &small->debuggee};
      });
  int patience = 200;
  session.meanwhile = [&] {
    if (--patience < 0 && session.debugger() != nullptr) session.debugger()->interrupt();
  };
  std::size_t asked = 0;
  const auto send = [&](std::string_view message) {
    const Json parsed = Json::parse(message, nullptr, false);
    asked += parsed.is_object() && debugger::dap::text_of(parsed, "type") == "request";
    session.handle(std::string(message));
    fuzz::expect(answers == asked, "a request without its one answer");
    if (session.runs()) session.run_on();
  };
  if (!text.starts_with('!'))
    for (const char* command : {"initialize", "launch", "configurationDone"})
      send(std::string(R"({"type":"request","seq":1,"command":")") + command +
           R"(","arguments":{"stopOnEntry":true,"stopAtEnd":true}})");
  std::string_view rest = text;
  for (std::size_t n = 0; n < most_messages && !rest.empty() && !session.over(); ++n) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    send(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return 0;
}
