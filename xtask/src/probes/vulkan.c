/* Loads Vulkan as a program does that is not linked with it, and fails where there is no device. Declares what it uses of
   vulkan/vulkan.h, which a driver does not need. */
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>

struct InstanceCreateInfo {
    int32_t type;
    const void *next;
    uint32_t flags;
    const void *application;
    uint32_t layer_count;
    const char *const *layers;
    uint32_t extension_count;
    const char *const *extensions;
};

int main(void) {
    void *library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        printf("%s\n", dlerror());
        return 1;
    }
    int32_t (*create)(const struct InstanceCreateInfo *, const void *, void **) =
        (int32_t(*)(const struct InstanceCreateInfo *, const void *, void **))dlsym(library, "vkCreateInstance");
    int32_t (*enumerate)(void *, uint32_t *, void **) =
        (int32_t(*)(void *, uint32_t *, void **))dlsym(library, "vkEnumeratePhysicalDevices");
    if (!create || !enumerate) {
        printf("libvulkan.so.1 is not a Vulkan loader\n");
        return 1;
    }
    struct InstanceCreateInfo info = {.type = 1};
    void *instance = 0;
    uint32_t count = 0;
    int32_t result = create(&info, 0, &instance);
    if (!result) result = enumerate(instance, &count, 0);
    if (result || !count) {
        printf("Vulkan has no device (result %d)\n", (int)result);
        return 1;
    }
    return 0;
}
