#include "c40/peripherals/comm_port.hpp"

#include <fmt/format.h>

namespace c40 {
namespace {

constexpr Address first_port = 0x00100040u, last_port = 0x0010009Fu;
constexpr Address port_stride = 0x10, registers_per_port = 3;

}  // namespace

bool is_port_register(Address address) {
  return address >= first_port && address <= last_port && (address - first_port) % port_stride < registers_per_port;
}

PortAccess port_access(Address address, bool write, Word value, Cycles cycle) {
  const Address offset = address - first_port;
  return {static_cast<int>(offset / port_stride),
          static_cast<PortRegister>(offset % port_stride),
          write,
          value,
          address,
          cycle};
}

Word Fifo::pop() {
  const Word word = words_[0];
  std::shift_left(words_.begin(), words_.end(), 1);
  words_[--count_] = 0;
  return word;
}

void CommPort::reset(int port) {
  traffic.discarded_input += input.size();
  traffic.discarded_output += output.size();
  input.clear();
  output.clear();
  input_halted = output_halted = false;
  token = token_after_reset(port);
}

Word CommPort::control() const {
  Word word = 0;
  word = cpcr::PORT_DIR.with(word, token ? 0 : 1);
  word = cpcr::ICH.with(word, input_halted);
  word = cpcr::OCH.with(word, output_halted);
  word = cpcr::OUTPUT_LEVEL.with(word, output.level());
  return cpcr::INPUT_LEVEL.with(word, input.level());
}

void CommPort::write_control(Word value) {
  input_halted = cpcr::ICH.in(value);
  output_halted = cpcr::OCH.in(value);
}

void CommPort::write(Word word) {
  output.push(word);
  ++traffic.written;
}

Word CommPort::read() {
  ++traffic.read;
  return input.pop();
}

Word CommPort::send() {
  ++traffic.sent;
  return output.pop();
}

void CommPort::receive(Word word) {
  input.push(word);
  ++traffic.received;
}

Word PortAccess::perform(CommPort& side) const {
  switch (reg) {
    case PortRegister::control:
      if (write) side.write_control(value);
      return side.control();
    case PortRegister::input: return write ? 0 : side.read();
    case PortRegister::output:
      if (write) side.write(value);
      return 0;
  }
  return 0;
}

std::string describe(const PortAccess& access) {
  constexpr std::array<std::string_view, 3> names{"the control register", "the input FIFO", "the output FIFO"};
  return fmt::format("{} {} of communication port {} ({:08X}h)", access.write ? "write to" : "read of",
                     names[static_cast<std::size_t>(access.reg)], access.port, access.address);
}

bool PortAccess::peek(const CommPort& side, Word& value_read) const {
  if (reg == PortRegister::output || (reg == PortRegister::input && side.input.empty())) return false;
  value_read = reg == PortRegister::control ? side.control() : side.input.words().front();
  return true;
}

}  // namespace c40
