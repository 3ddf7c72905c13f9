// SPDX-License-Identifier: BSD-2-Clause
#include "drivers/imu_can/openimu300.h"

namespace facet {
namespace {

// Identifiers: priority 3, parameter group, source address 0x80 (the device's default), and DBC's flag of 29 bits.
//   0x8CF02980 = 2364549504, 0x8CF02A80 = 2364549760, 0x8CF02D80 = 2364550528
constexpr std::string_view kDatabase = R"dbc(VERSION "OpenIMU300RI J1939"

NS_ :

BS_:

BU_: OpenIMU300

BO_ 2364549504 SlopeSensor2: 8 OpenIMU300
 SG_ Pitch : 0|24@1+ (3.0517578125E-05,-250) [-250|251.99998] "deg" Vector__XXX
 SG_ Roll : 24|24@1+ (3.0517578125E-05,-250) [-250|251.99998] "deg" Vector__XXX

BO_ 2364549760 AngularRate: 8 OpenIMU300
 SG_ RateX : 0|16@1+ (0.0078125,-250) [-250|251.995] "deg/s" Vector__XXX
 SG_ RateY : 16|16@1+ (0.0078125,-250) [-250|251.995] "deg/s" Vector__XXX
 SG_ RateZ : 32|16@1+ (0.0078125,-250) [-250|251.995] "deg/s" Vector__XXX

BO_ 2364550528 Acceleration: 8 OpenIMU300
 SG_ AccelX : 0|16@1+ (0.01,-320) [-320|322.555] "m/s^2" Vector__XXX
 SG_ AccelY : 16|16@1+ (0.01,-320) [-320|322.555] "m/s^2" Vector__XXX
 SG_ AccelZ : 32|16@1+ (0.01,-320) [-320|322.555] "m/s^2" Vector__XXX
)dbc";

}  // namespace

std::string_view openimu300_dbc() { return kDatabase; }

CanSignalMap openimu300_map() {
    CanSignalMap map;
    map.rate = {{{"AngularRate", "RateX"}, {"AngularRate", "RateY"}, {"AngularRate", "RateZ"}}};
    map.force = {{{"Acceleration", "AccelX"}, {"Acceleration", "AccelY"}, {"Acceleration", "AccelZ"}}};
    map.j1939 = true;
    return map;
}

}  // namespace facet
