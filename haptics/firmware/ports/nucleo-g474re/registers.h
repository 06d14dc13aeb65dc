/* Registers of an STM32G474 that this port uses, by address; names as in ST's reference manual RM0440. */
#ifndef DELTA_REGISTERS_H
#define DELTA_REGISTERS_H

#include <stdint.h>

enum {
    RCC_CR = 0x40021000, RCC_CFGR = 0x40021008, RCC_PLLCFGR = 0x4002100C, RCC_AHB2ENR = 0x4002104C,
    RCC_APB1ENR1 = 0x40021058, RCC_APB1ENR2 = 0x4002105C, RCC_CSR = 0x40021094, FLASH_ACR = 0x40022000,
    PWR_CR5 = 0x40007080, TIM2_CR1 = 0x40000000, TIM2_EGR = 0x40000014, TIM2_CNT = 0x40000024,
    TIM2_ARR = 0x4000002C, TIM6_CR1 = 0x40001000, TIM6_SR = 0x40001010, TIM6_EGR = 0x40001014,
    TIM6_PSC = 0x40001028, TIM6_ARR = 0x4000102C, IWDG_KR = 0x40003000, IWDG_PR = 0x40003004,
    IWDG_RLR = 0x40003008, IWDG_SR = 0x4000300C, SPI3_CR1 = 0x40003C00, SPI3_CR2 = 0x40003C04,
    SPI3_SR = 0x40003C08, SPI3_DR = 0x40003C0C, LPUART1_CR1 = 0x40008000, LPUART1_BRR = 0x4000800C,
    LPUART1_ISR = 0x4000801C, LPUART1_ICR = 0x40008020, LPUART1_RDR = 0x40008024, LPUART1_TDR = 0x40008028
};
/* Above 0x7FFFFFFF an enumerator is no int. */
#define GPIOA 0x48000000u
#define GPIOB 0x48000400u
#define GPIOC 0x48000800u
#define GPIO_MODER 0x00u
#define GPIO_OSPEEDR 0x08u
#define GPIO_PUPDR 0x0Cu
#define GPIO_IDR 0x10u
#define GPIO_BSRR 0x18u
#define GPIO_AFRL 0x20u
#define GPIO_AFRH 0x24u
#define DAC1 0x50000800u
#define DAC2 0x50000C00u
#define DAC_CR 0x00u
#define DAC_DHR12R1 0x08u
#define DAC_DHR12R2 0x14u
#define DAC_MCR 0x3Cu
#define NVIC_ISER2 0xE000E108u

#ifdef DELTA_SIMULATED_REGISTERS
/* On another machine: what stands for the chip defines these. */
uint32_t reg_get(uint32_t address);
void reg_put(uint32_t address, uint32_t value);
void reg_put_byte(uint32_t address, uint32_t value);
#else
static inline uint32_t reg_get(uint32_t address) { return *(volatile uint32_t *)address; }
static inline void reg_put(uint32_t address, uint32_t value) { *(volatile uint32_t *)address = value; }
/* SPI's data register takes one byte by an access of a byte, two by any other. */
static inline void reg_put_byte(uint32_t address, uint32_t value) { *(volatile uint8_t *)address = (uint8_t)value; }
#endif

static inline void reg_set(uint32_t address, uint32_t bits) { reg_put(address, reg_get(address) | bits); }
/* A field of some bits at a place. */
static inline void reg_field(uint32_t address, unsigned at, uint32_t mask, uint32_t value)
{
    reg_put(address, (reg_get(address) & ~(mask << at)) | value << at);
}

#endif
