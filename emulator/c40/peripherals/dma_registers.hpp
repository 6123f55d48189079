#pragma once
/// The registers of a DMA channel (c40-hardware.md 3.1).
#include "c40/peripherals/fields.hpp"

namespace c40 {

inline constexpr int dma_channel_count = 6;

/// In the order of their addresses, from 1000A0h + 10h * channel on.
enum class DmaRegister : std::uint8_t {
  control,
  source,
  source_index,
  counter,
  destination,
  destination_index,
  link,
  auxiliary_counter,
  auxiliary_link
};
inline constexpr int dma_register_count = 9;

namespace dma_control {
inline constexpr Field PRI{"DMA PRI", 0, 2, FieldAccess::read_write,
                           "against the CPU: 00 CPU first, 01 rotating, 11 DMA first"};
inline constexpr Field MODE{"TRANSFER MODE", 2, 2, FieldAccess::read_write,
                            "at counter 0: 00 continue, 01 stop, 10 autoinitialise, 11 autoinitialise when restarted"};
inline constexpr Field AUX_MODE{"AUX TRANSFER MODE", 4, 2, FieldAccess::read_write,
                                "the same of the auxiliary channel"};
inline constexpr Field SYNC_READ{"READ SYNC", 6, 1, FieldAccess::read_write, "a read waits for the source's event"};
inline constexpr Field SYNC_WRITE{"WRITE SYNC", 7, 1, FieldAccess::read_write,
                                  "a write waits for the destination's event"};
inline constexpr Field STATIC{"AUTOINIT STATIC", 8, 1, FieldAccess::read_write,
                              "the link pointer stays while the list is read"};
inline constexpr Field AUX_STATIC{"AUX AUTOINIT STATIC", 9, 1, FieldAccess::read_write,
                                  "the same of the auxiliary channel"};
inline constexpr Field AUTOINIT_SYNC{"AUTOINIT SYNC", 10, 1, FieldAccess::read_write,
                                     "each read of the list waits for the source's event"};
inline constexpr Field AUX_AUTOINIT_SYNC{"AUX AUTOINIT SYNC", 11, 1, FieldAccess::read_write,
                                         "the same of the auxiliary channel"};
inline constexpr Field READ_BIT_REV{"READ BIT REV", 12, 1, FieldAccess::read_write,
                                    "the source steps with reversed carry"};
inline constexpr Field WRITE_BIT_REV{"WRITE BIT REV", 13, 1, FieldAccess::read_write,
                                     "the destination steps with reversed carry"};
inline constexpr Field SPLIT{"SPLIT MODE", 14, 1, FieldAccess::read_write,
                             "primary: memory to port; auxiliary: port to memory"};
inline constexpr Field COM_PORT{"COM PORT", 15, 3, FieldAccess::read_write, "the port in split mode"};
inline constexpr Field TCC{"TCC", 18, 1, FieldAccess::read_write, "DMAINT to the CPU at the end of a block"};
inline constexpr Field AUX_TCC{"AUX TCC", 19, 1, FieldAccess::read_write, "the same of the auxiliary channel"};
inline constexpr Field TCINT{"TCINT FLAG", 20, 1, FieldAccess::read_write,
                             "a block has ended, its last word is written"};
inline constexpr Field AUX_TCINT{"AUX TCINT FLAG", 21, 1, FieldAccess::read_write, "the same of the auxiliary channel"};
inline constexpr Field START{"START", 22, 2, FieldAccess::read_write,
                             "00 reset, 01 halt at a read or write, 10 halt between words, 11 run"};
inline constexpr Field AUX_START{"AUX START", 24, 2, FieldAccess::read_write, "the same of the auxiliary channel"};
inline constexpr Field STATUS{"STATUS", 26, 2, FieldAccess::read_only,
                              "00 held between words, 01 held within one, 11 busy"};
inline constexpr Field AUX_STATUS{"AUX STATUS", 28, 2, FieldAccess::read_only, "the same of the auxiliary channel"};
inline constexpr Field PRIORITY_MODE{"PRIORITY MODE", 30, 1, FieldAccess::read_write,
                                     "channel 0 only: 1 fixed order of the channels, 0 rotating"};
/// A value of START and AUX START.
inline constexpr Word start_run = 3;
}  // namespace dma_control

}  // namespace c40
