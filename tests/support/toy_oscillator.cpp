#include "tests/support/toys.hpp"

int main(int argc, char** argv)
{
    return sluice::run(argc, argv, [](sluice::Participant& self) { toys::oscillator(self); });
}
