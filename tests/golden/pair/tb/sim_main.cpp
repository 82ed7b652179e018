// SPDX-License-Identifier: MIT OR Apache-2.0
// sim_main: clock and dump around the replaying bench, for Verilator (--prefix Vtb)
//
// Rising edge k is at 5 ns + k * 10 ns, as in the Icarus bench, so that the dumps lie
// on top of each other. A plain loop instead of Verilator's own timing: it builds in a
// fraction of the time and runs faster.
//   +stimulus=FILE  read by the Verilog bench
//   +dump=FILE      dump of every signal (only in a build with --trace)
//   +bench          print the clocks simulated and the seconds they took

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>

#include "Vtb.h"
#include "verilated.h"
#if VM_TRACE
#include "verilated_vcd_c.h"
#endif

namespace {

constexpr uint64_t kHalfPeriodPs = 5000;
// The Verilog bench has its own, lower limit; this one holds if it does not work.
constexpr uint64_t kMaxClocks = 100000100;

}  // namespace

int main(int argc, char** argv) {
    const auto context = std::make_unique<VerilatedContext>();
    context->commandArgs(argc, argv);
    // Copied: the next question overwrites the answer.
    const std::string dump = context->commandArgsPlusMatch("dump=");
    const bool bench = *context->commandArgsPlusMatch("bench") != '\0';
#if VM_TRACE
    context->traceEverOn(!dump.empty());
#else
    if (!dump.empty()) {
        std::printf("hwgen: this build cannot dump\n");
        return 1;
    }
#endif

    const auto top = std::make_unique<Vtb>(context.get());
#if VM_TRACE
    std::unique_ptr<VerilatedVcdC> trace;
    if (!dump.empty()) {
        trace = std::make_unique<VerilatedVcdC>();
        top->trace(trace.get(), 99);
        trace->open(dump.c_str() + std::strlen("+dump="));
        if (!trace->isOpen()) {
            std::printf("hwgen: the dump file cannot be opened\n");
            return 1;
        }
    }
#endif

    uint64_t clocks = 0;
    top->clk_i = 0;
    top->eval();
#if VM_TRACE
    if (trace) trace->dump(context->time());
#endif
    const auto start = std::chrono::steady_clock::now();
    while (!context->gotFinish() && clocks < kMaxClocks) {
        context->timeInc(kHalfPeriodPs);
        top->clk_i = !top->clk_i;
        top->eval();
        clocks += top->clk_i;
#if VM_TRACE
        if (trace) trace->dump(context->time());
#endif
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;

    top->final();
#if VM_TRACE
    if (trace) trace->close();
#endif
    if (bench) {
        std::printf("hwgen: %llu clocks in %.6f seconds\n",
                    static_cast<unsigned long long>(clocks), seconds.count());
    }
    if (!context->gotFinish()) {
        std::printf("hwgen: stopped at the limit of %llu clocks\n",
                    static_cast<unsigned long long>(kMaxClocks));
        return 1;
    }
    return 0;
}
