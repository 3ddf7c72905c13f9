// SPDX-License-Identifier: BSD-2-Clause
// Ready database and signal map of the Aceinna OpenIMU300RI on J1939.
#pragma once

#include <string_view>

#include "drivers/imu_can/dbc_decoder.h"

namespace facet {

/// Database with the slope sensor (PGN 61481), angular rate (61482) and acceleration (61485) messages. Source: OpenIMU
/// documentation, "CAN J1939 Data Messages" (openimu.readthedocs.io): little-endian, slope 1/32768 deg per bit from
/// -250 deg in 24 bits, rate 1/128 deg/s per bit from -250 deg/s, acceleration 0.01 m/s^2 per bit from -320 m/s^2.
/// Values from 0xFB00 on are J1939's codes for "error" and "not available"; the ranges refuse them.
std::string_view openimu300_dbc();

/// Rates and forces of that database, from any source address.
CanSignalMap openimu300_map();

}  // namespace facet
