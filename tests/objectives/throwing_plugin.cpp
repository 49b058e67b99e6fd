// A plug-in whose opening throws: exceptions may not leave a C function, but authors forget.
#include <stdexcept>

#include "strake/plugin.h"

extern "C" {
uint32_t strake_plugin_abi() { return STRAKE_PLUGIN_ABI; }
int strake_plugin_open(const char*, void**, char*, size_t) { throw std::runtime_error("no licence today"); }
int strake_plugin_evaluate(void*, const strake_plugin_request*, strake_plugin_result*) { return 1; }
}
