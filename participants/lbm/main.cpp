#include "participants/lbm/coupling.hpp"

int main(int argc, char** argv)
{
    return lbm::main(argc, argv);
}
