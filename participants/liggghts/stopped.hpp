#pragma once

#include <string>

namespace liggghts {

//! What LIGGGHTS says when it gives up. It would end the process; here its error functions throw this (stopped.cpp).
struct Stopped
{
    std::string text;
};

//! Where its warnings go while its log is set aside; null: to its log.
void set_warning_file(void* file);

}  // namespace liggghts
