#include "participants/dem/coupling.hpp"

int main(int argc, char** argv)
{
    return dem::main(argc, argv);
}
