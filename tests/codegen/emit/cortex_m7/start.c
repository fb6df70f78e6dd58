/* Start-up of a Cortex-M7 in an emulator: floating-point unit on, cycle counter on, output and end by semihosting. */
#include <stdint.h>

int main(void);
void print(const char *text);
void reset(void);
uint32_t ticks(void);

void print(const char *text)
{
    register int r0 __asm__("r0") = 4;
    register const char *r1 __asm__("r1") = text;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

/* One tick of SysTick is 40 instructions in QEMU with -icount shift=0 (25 MHz beside one instruction a ns). */
uint32_t ticks(void)
{
    return 0xffffffu - *(volatile uint32_t *)0xE000E018;
}

void reset(void)
{
    *(volatile uint32_t *)0xE000ED88 |= 0xfu << 20;
    __asm__ volatile("dsb; isb");
    *(volatile uint32_t *)0xE000E014 = 0xffffff;
    *(volatile uint32_t *)0xE000E018 = 0;
    *(volatile uint32_t *)0xE000E010 = 5;
    main();
    register int r0 __asm__("r0") = 0x18;
    register int r1 __asm__("r1") = 0x20026;
    __asm__ volatile("bkpt 0xab" ::"r"(r0), "r"(r1));
    for (;;) { }
}

__attribute__((section(".vectors"), used)) const uintptr_t vectors[] = {0x20400000, (uintptr_t)reset};
