#include "participants/liggghts/coupling.hpp"

int main(int argc, char** argv)
{
    return liggghts::main(argc, argv);
}
