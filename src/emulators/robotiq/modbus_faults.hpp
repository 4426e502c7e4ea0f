#pragma once
#include "stonestack/core/options.hpp"

namespace stonestack::emulators {

/// Faults of a simulated Modbus device on the wire. Numbers count the replies that are spoiled from now
/// on: 0 none, -1 all. Each reply meets every fault that is still armed, in this order.
struct ModbusFaults {
  int no_reply = 0;           ///< the request is carried out, nothing comes back
  int hang_up = 0;            ///< the connection is closed instead of a reply (TCP)
  int exceptions = 0;         ///< the reply is `exception` and the request is not carried out
  int exception = 6;          ///< code
  int delayed = 0;            ///< the reply comes late by `delay`
  double delay = 0.5;         ///< [s]
  int wrong_unit = 0;         ///< by another unit id
  int wrong_transaction = 0;  ///< with another transaction id (TCP)
  int wrong_count = 0;        ///< a byte count that does not fit
  int bad_crc = 0;            ///< one bit flipped in the CRC (RTU)
  int merged = 0;             ///< behind another reply, in one piece (TCP) or behind half of one (RTU)
  int truncated = 0;          ///< half of the reply
  int garbage = 0;            ///< bytes that are no frame
  bool fragments = false;     ///< byte by byte
};
[[nodiscard]] FieldList fields(ModbusFaults& faults);

}  // namespace stonestack::emulators
