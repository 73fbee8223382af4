#pragma once

namespace mpm {

//! The MPM as a participant of a run. It neither takes nor sends data yet.
int main(int argc, char** argv);

}  // namespace mpm
