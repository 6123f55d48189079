#pragma once
/// Which pins a net connects (machine/networks/net.hpp): its text, and what no net can be.
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "c40/peripherals/pins.hpp"

namespace machine {

/// One pin of one chip.
struct ChipPin {
  std::size_t chip = 0;
  c40::Pin pin = c40::Pin::iiof0;
  friend bool operator==(const ChipPin&, const ChipPin&) = default;
};

struct NetDescription {
  std::string name;  ///< empty: the net's number
  std::vector<ChipPin> drivers, receivers;
  bool open_drain = false;
  bool rest = true;  ///< the level without a driver

  bool is_driven() const { return !drivers.empty(); }
};

/// "0.TCLK0>1.IIOF1+2.NMI"; wired-and: "0.IIOF1&1.IIOF1>2.IIOF0"; driven only by a script: ">1.TCLK0". A name may come
/// first: "index: >1.IIOF2".
/// \param chips the names of the chips; numbers are possible too
/// \throws std::invalid_argument with what would be right
NetDescription parse_net(std::string_view text, const std::vector<std::string>& chips);
ChipPin parse_pin(std::string_view text, const std::vector<std::string>& chips);
std::string to_text(const ChipPin& pin);
/// Without the name.
std::string to_text(const NetDescription& net);
/// \throws std::invalid_argument for impossible nets: a pin on two nets, an input as a driver, two drivers
void check(const std::vector<NetDescription>& nets, std::size_t chips);
/// "0.TCLK0>1.IIOF1, 1.TCLK0>0.TCLK1": nets between the dock's slots. \throws std::invalid_argument
std::vector<NetDescription> parse_slot_nets(std::string_view text, std::size_t slots);
/// The same, and no net at IIOF0, which is the host's doorbell. \throws std::invalid_argument
void check_slot_nets(const std::vector<NetDescription>& nets, std::size_t slots);
/// By its name, else its number. \throws std::invalid_argument with the known names
std::size_t net_named(std::string_view text, const std::vector<NetDescription>& nets);

}  // namespace machine
