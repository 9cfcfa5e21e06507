#include <cstdint>
#include <string>

int main(int count, char **arguments) {
    std::string name(arguments[0]);
    return name.size() + static_cast<std::size_t>(count) == 0;
}
