// Counts the instructions that an emulated program executes, and prints the sum when it ends.
// The names and their order are those of qemu-plugin.h, version 1 of the interface.
#include <inttypes.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

typedef uint64_t plugin_id;
struct tb;
typedef void (*tb_cb)(plugin_id, struct tb *);
typedef void (*exec_cb)(unsigned int, void *);
typedef void (*end_cb)(plugin_id, void *);
void qemu_plugin_register_vcpu_tb_trans_cb(plugin_id, tb_cb);
void qemu_plugin_register_vcpu_tb_exec_cb(struct tb *, exec_cb, int, void *);
void qemu_plugin_register_atexit_cb(plugin_id, end_cb, void *);
size_t qemu_plugin_tb_n_insns(const struct tb *);
void qemu_plugin_outs(const char *);

int qemu_plugin_version = 1;
static uint64_t executed;

static void runs(unsigned int cpu, void *count) {
    (void)cpu;
    __atomic_fetch_add(&executed, (uint64_t)(uintptr_t)count, __ATOMIC_RELAXED);
}

static void translated(plugin_id id, struct tb *block) {
    (void)id;
    uintptr_t count = qemu_plugin_tb_n_insns(block);
    qemu_plugin_register_vcpu_tb_exec_cb(block, runs, 0, (void *)count);
}

static void ends(plugin_id id, void *nothing) {
    (void)id;
    (void)nothing;
    char line[64];
    snprintf(line, sizeof line, "instructions %" PRIu64 "\n", executed);
    qemu_plugin_outs(line);
}

int qemu_plugin_install(plugin_id id, const void *info, int argc, char **argv) {
    (void)info;
    (void)argc;
    (void)argv;
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, ends, NULL);
    return 0;
}
