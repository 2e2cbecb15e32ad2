#include "catalog/device_configs.hpp"

#include "catalog/option_rows.hpp"

namespace clbvh {

DeviceBuilderConfigs device_configs_for(std::string_view builder_id, const BuildOptions& options) {
    BuildOptions read = options;
    for (const OptionRow& row : option_rows()) {
        if (!reads_option(builder_id, row.name)) set_value(row.value, row.name, get_value(row.value, {}), read);
    }
    return static_cast<const DeviceBuilderConfigs&>(read);
}

}  // namespace clbvh
