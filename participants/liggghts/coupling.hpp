#pragma once

namespace liggghts {

//! A LIGGGHTS as a participant of a coupled run: sends `kinematics`, takes `load`; either may be left out.
int main(int argc, char** argv);

}  // namespace liggghts
