// SPDX-License-Identifier: Apache-2.0
#include "server/compute/devices_json.h"

#include <nlohmann/json.hpp>

namespace kiln {

std::string to_json(const std::vector<DeviceInfo>& devices) {
    using Json = nlohmann::ordered_json;
    Json all = Json::array();
    for (const DeviceInfo& device : devices)
        all.push_back({{"backend", device.backend},
                       {"name", device.name},
                       {"vendor", device.vendor},
                       {"version", device.version},
                       {"numerics", device.numerics},
                       {"compute_units", device.compute_units},
                       {"usable", device.usable},
                       {"detail", device.detail}});
    return all.dump(-1, ' ', true, Json::error_handler_t::replace);
}

}  // namespace kiln
