#pragma once
/// Starts a chip as its RESET pin does: the boot ROM, the pins that choose its source, and the streams that the loader
/// reads (c40-hardware.md 9). The loader itself is C40 code, c40_programs/boot_rom.asm.
#include <span>
#include <vector>

#include "c40/chip/chip.hpp"
#include "toolchain/objects/image.hpp"

namespace machine {

/// The contents of a boot stream besides the program's blocks.
struct BootHeader {
  c40::Word global_interface_control = 0x3E39FFF0u;
  c40::Word local_interface_control = 0x3E39FFF0u;
  c40::Word ivtp = 0, tvtp = 0;
  c40::Address acknowledge = 0x002FF800u;  ///< the address that the loader's IACK reads
};

/// The board with the boot ROM at 0, and with pins for which the loader takes the first port that has a word.
c40::Board with_boot_from_port(c40::Board board);
/// The same, with pins for memory at this address. Throws std::invalid_argument if no pins select it.
c40::Board with_boot_from_memory(c40::Board board, c40::Address address);

/// What a chip does after reset on this board.
enum class ResetSource : std::uint8_t {
  ports,   ///< the boot loader takes the first port that has a word
  memory,  ///< the boot loader reads a stream at boot_address()
  vector   ///< no boot loader: the program begins at the address in the reset vector
};
ResetSource reset_source(const c40::Board& board);
/// The address of the memory that the pins select.
c40::Address boot_address(const c40::Board& board);

/// The stream for a port (c40-hardware.md 9.3): the block that begins at the entry comes first. Throws
/// std::invalid_argument if the entry is in no section, or a section is below 1000h, where the ROM is.
std::vector<c40::Word> boot_stream(const toolchain::Image& image, const BootHeader& header);
/// The same for memory of 32 bits (c40-hardware.md 9.2).
std::vector<c40::Word> boot_memory(const toolchain::Image& image, const BootHeader& header);

/// For a stream of boot_memory that lies in memory at this address: throws std::invalid_argument if the loader would
/// write a section over words of the stream that it has not read yet.
void require_not_overwritten(std::span<const c40::Word> stream, c40::Address at, const toolchain::Image& image);

/// Feeds a boot stream into a port without a link, at a link's speed, whenever the chip waits for a word.
class BootFeeder {
 public:
  BootFeeder(c40::Chip& chip, int port, std::vector<c40::Word> stream);
  /// True: a word was delivered for the access at which the chip stopped; the chip can run on.
  bool serve(const c40::PortAccess& access);
  int port() const { return port_; }
  std::size_t sent() const { return sent_; }
  std::size_t size() const { return stream_.size(); }

 private:
  c40::Chip& chip_;
  int port_;
  std::vector<c40::Word> stream_;
  std::size_t sent_ = 0;
  c40::Cycles next_ = 0;
};

}  // namespace machine
