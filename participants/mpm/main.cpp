#include "participants/mpm/coupling.hpp"

int main(int argc, char** argv)
{
    return mpm::main(argc, argv);
}
