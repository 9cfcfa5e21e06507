#include <math.h>
#include <stdint.h>
#include <stdio.h>

int main(int count, char **arguments) {
    (void)arguments;
    uint64_t one = (uint64_t)count;
    printf("%g\n", sqrt((double)one));
    return 0;
}
