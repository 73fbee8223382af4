#pragma once

namespace lbm {

//! The LBM as a participant of a coupled run: takes `kinematics`, sends `load`; either may be left out.
int main(int argc, char** argv);

}  // namespace lbm
