// SPDX-License-Identifier: GPL-2.0
/*
 * An SPI controller without wires and one inertial sensor on it, for the hardware-in-the-loop tests. The sensor is
 * bound to the kernel's spidev, so that user space finds a real /dev/spidev0.0; its measurements are written to
 * /dev/facet-imu.
 *
 * chip=icm42688: TDK ICM-42688-P, byte registers of bank 0, FIFO, self-test response.
 * chip=adis16475: Analog Devices ADIS16475-2, 16-bit registers answered one frame later, burst read.
 * chip=bmi088: Bosch BMI088, gyroscope on chip select 0 and accelerometer on 1, which comes up speaking I2C and
 *              answers a read one byte later; sensor time in ticks of 39.0625 us, self-test responses.
 *
 * /dev/facet-imu, written at offset
 *   0x0000 + r  register r (ADIS: bytes of the 16-bit registers, low one first)
 *   0x1000      appended to the FIFO, all or nothing, if the FIFO is on (ICM)
 *   0x2000      the words that a burst gives from now on (ADIS); six bytes of rates, six of forces and three of the
 *               sensor time of this moment, which goes on until it would be that of the next sample (BMI)
 *   0x3000      one byte: 0 the bus works, 1 nobody drives the line (all ones are read), 2 the bus works and the
 *               sensor has just come up, its registers as after power-on
 * and read at 0x0000 + r: the register; at 0x3000: 1 if the sensor is set up to make data-ready edges.
 */
#include <linux/fs.h>
#include <linux/init.h>
#include <linux/kfifo.h>
#include <linux/ktime.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/spi/spi.h>
#include <linux/uaccess.h>

#define ICM_DEVICE_CONFIG 0x11
#define ICM_ACCEL_DATA 0x1f
#define ICM_FIFO_COUNT 0x2e
#define ICM_FIFO_DATA 0x30
#define ICM_SIGNAL_PATH_RESET 0x4b
#define ICM_SELF_TEST 0x70
#define ICM_WHO_AM_I 0x75
#define ICM_BANK 0x76
#define ICM_PACKET 20
#define ICM_FIFO_CONFIG 0x16
#define ICM_INT_SOURCE0 0x65

#define ADIS_RANG_MDL 0x5e
#define ADIS_GLOB_CMD 0x68
#define ADIS_PROD_ID 0x72
#define ADIS_BURST 20

#define BMI_CHIP_ID 0x00
#define BMI_RESET_VALUE 0xb6
#define BMI_GYRO_DATA 0x02
#define BMI_GYRO_BANDWIDTH 0x10
#define BMI_GYRO_RESET 0x14
#define BMI_GYRO_INT_CTRL 0x15
#define BMI_GYRO_INT_MAP 0x18
#define BMI_GYRO_SELF_TEST 0x3c
#define BMI_ACCEL_DATA 0x12
#define BMI_ACCEL_TIME 0x18
#define BMI_ACCEL_TEMPERATURE 0x22
#define BMI_ACCEL_SELF_TEST 0x6d
#define BMI_ACCEL_PWR_CONF 0x7c
#define BMI_ACCEL_PWR_CTRL 0x7d
#define BMI_ACCEL_RESET 0x7e
#define BMI_MEASURED 15
#define BMI_TICK_PS 39062500ULL
#define BMI_LAST_TICK 15 /* of a sample: sixteen at 1600 Hz */

#define AT_FIFO 0x1000
#define AT_BURST 0x2000
#define AT_BUS 0x3000

static char *chip = "icm42688";
module_param(chip, charp, 0444);
MODULE_PARM_DESC(chip, "icm42688, adis16475 or bmi088");

enum chip_kind { ICM42688, ADIS16475, BMI088 };
static const char *const names[] = { "icm42688", "adis16475", "bmi088" };
static enum chip_kind kind;
static DEFINE_SPINLOCK(lock);
static u8 registers[256];
static u8 burst[ADIS_BURST];
static u8 accel[128]; /* registers of the BMI088's accelerometer; the gyroscope's are in registers[] */
static u8 measured[BMI_MEASURED];
static ktime_t measured_at;
static bool accel_speaks_spi;
static DEFINE_KFIFO(fifo, u8, 4096);
static bool dead;

/* Between the edges of chip-select. */
struct frame {
	unsigned int at;
	u8 command;
	u8 address;
};
static u16 adis_answer; /* to the read of the frame before */

static void icm_reset(void)
{
	memset(registers, 0, sizeof(registers));
	registers[ICM_WHO_AM_I] = 0x47;
	kfifo_reset(&fifo);
}

static void icm_write(u8 address, u8 value)
{
	if (registers[ICM_BANK] != 0 && address != ICM_BANK)
		return;
	if (address == ICM_DEVICE_CONFIG && (value & 1))
		icm_reset();
	else if (address == ICM_SIGNAL_PATH_RESET && (value & 2))
		kfifo_reset(&fifo);
	else if (address != ICM_WHO_AM_I)
		registers[address] = value;
}

/* The packets that are still there, where an empty FIFO gives the mark of an empty header. */
static u8 icm_read(struct frame *f)
{
	unsigned int records = kfifo_len(&fifo) / ICM_PACKET;
	u8 value;

	switch (f->address) {
	case ICM_FIFO_COUNT:
		value = records >> 8;
		break;
	case ICM_FIFO_COUNT + 1:
		value = records & 0xff;
		break;
	case ICM_FIFO_DATA: /* the address stays */
		return kfifo_get(&fifo, &value) ? value : 0x80;
	case ICM_ACCEL_DATA ... ICM_ACCEL_DATA + 11: /* 0.3 g and 100 deg/s while the self-test is on */
		value = 0;
		if (registers[ICM_SELF_TEST]) {
			u16 response = f->address < ICM_ACCEL_DATA + 6 ? 614 : 1638;

			value = (f->address - ICM_ACCEL_DATA) & 1 ? response & 0xff : response >> 8;
		}
		break;
	default:
		value = registers[f->address];
	}
	f->address = (f->address + 1) & 0x7f;
	return value;
}

static u8 icm_byte(struct frame *f, u8 in)
{
	if (f->at++ == 0) {
		f->command = in;
		f->address = in & 0x7f;
		return 0xff;
	}
	if (f->command & 0x80)
		return icm_read(f);
	icm_write(f->address, in);
	f->address = (f->address + 1) & 0x7f;
	return 0xff;
}

static void adis_write(u8 address, u8 value)
{
	if ((address & ~1) != ADIS_PROD_ID && (address & ~1) != ADIS_RANG_MDL && (address & ~1) != ADIS_GLOB_CMD)
		registers[address] = value;
}

static u8 adis_byte(struct frame *f, u8 in)
{
	unsigned int at = f->at++;
	u8 out = at == 0 ? adis_answer >> 8 : adis_answer & 0xff;

	if (at == 0) {
		f->command = in;
		return out;
	}
	if (at == 1) {
		if (f->command & 0x80)
			adis_write(f->command & 0x7f, in);
		else
			adis_answer = registers[f->command & 0x7e] | registers[(f->command & 0x7e) + 1] << 8;
		return out;
	}
	/* Clocked on after the command that starts a burst. */
	return f->command == ADIS_GLOB_CMD && at - 2 < ADIS_BURST ? burst[at - 2] : 0;
}

static void bmi_reset_gyro(void)
{
	memset(registers, 0, sizeof(registers));
	registers[BMI_CHIP_ID] = 0x0f;
	registers[BMI_GYRO_BANDWIDTH] = 0x80;
}

static void bmi_reset_accel(void)
{
	memset(accel, 0, sizeof(accel));
	accel[BMI_CHIP_ID] = 0x1e;
	accel[BMI_ACCEL_PWR_CONF] = 0x03; /* suspended */
	accel[BMI_ACCEL_TEMPERATURE] = 2; /* 25 deg C, in steps of 0.125 from 23 */
	accel_speaks_spi = false;
}

static void bmi_gyro_write(u8 address, u8 value)
{
	if (address == BMI_GYRO_RESET && value == BMI_RESET_VALUE)
		bmi_reset_gyro();
	else if (address == BMI_GYRO_SELF_TEST && (value & 1))
		registers[address] = 0x12; /* done, rate good */
	else if (address == BMI_GYRO_BANDWIDTH)
		registers[address] = 0x80 | value;
	else if (address != BMI_CHIP_ID)
		registers[address] = value;
}

static u8 bmi_gyro_read(u8 address)
{
	if (address >= BMI_GYRO_DATA && address < BMI_GYRO_DATA + 6)
		return measured[address - BMI_GYRO_DATA];
	return registers[address];
}

static void bmi_accel_write(u8 address, u8 value)
{
	if (address == BMI_ACCEL_RESET && value == BMI_RESET_VALUE)
		bmi_reset_accel();
	else if (address != BMI_CHIP_ID && address != BMI_ACCEL_RESET)
		accel[address] = value;
}

/* 0.8 g either way at 24 g full scale, x first, low byte first, while the self-test is on. */
static u8 bmi_accel_read(u8 address)
{
	u32 time;

	if (address >= BMI_ACCEL_DATA && address < BMI_ACCEL_DATA + 6) {
		s16 response = accel[BMI_ACCEL_SELF_TEST] == 0x0d ? 1092 : -1092;
		u8 at = address - BMI_ACCEL_DATA;

		if (accel[BMI_ACCEL_PWR_CONF] != 0 || accel[BMI_ACCEL_PWR_CTRL] != 4)
			return 0;
		if (accel[BMI_ACCEL_SELF_TEST])
			return at & 1 ? (u16)response >> 8 : response & 0xff;
		return measured[6 + at];
	}
	if (address >= BMI_ACCEL_TIME && address < BMI_ACCEL_TIME + 3) {
		u64 ticks = div64_u64((u64)(ktime_get() - measured_at) * 1000, BMI_TICK_PS);

		time = measured[12] | measured[13] << 8 | measured[14] << 16;
		time += min_t(u64, ticks, BMI_LAST_TICK - (time & BMI_LAST_TICK));
		return time >> (8 * (address - BMI_ACCEL_TIME));
	}
	return accel[address];
}

static u8 bmi_byte(struct frame *f, u8 in, bool is_accel)
{
	u8 out = 0xff;

	if (f->at++ == 0) {
		f->command = in;
		f->address = in & 0x7f;
		return out;
	}
	if (!(f->command & 0x80)) {
		if (is_accel)
			bmi_accel_write(f->address, in);
		else
			bmi_gyro_write(f->address, in);
	} else if (!is_accel) {
		out = bmi_gyro_read(f->address);
	} else if (f->at == 2 || !accel_speaks_spi) {
		return out; /* what comes before the data, or anything while it speaks I2C */
	} else {
		out = bmi_accel_read(f->address);
	}
	f->address = (f->address + 1) & 0x7f;
	return out;
}

static u8 byte_of(struct frame *f, u8 in, unsigned int chip_select)
{
	if (dead)
		return 0xff;
	switch (kind) {
	case ADIS16475:
		return adis_byte(f, in);
	case BMI088:
		return bmi_byte(f, in, chip_select == 1);
	default:
		return icm_byte(f, in);
	}
}

static void power_on(void)
{
	if (kind == ICM42688) {
		icm_reset();
	} else if (kind == BMI088) {
		bmi_reset_gyro();
		bmi_reset_accel();
	} else {
		memset(registers, 0, sizeof(registers));
		registers[ADIS_PROD_ID] = 0x5b;
		registers[ADIS_PROD_ID + 1] = 0x40;
		registers[ADIS_RANG_MDL] = 1 << 2;
	}
}

/* An ADIS16475 makes its edges from power-on. */
static u8 makes_edges(void)
{
	switch (kind) {
	case ICM42688:
		return registers[ICM_FIFO_CONFIG] == 0x40 && (registers[ICM_INT_SOURCE0] & 4);
	case BMI088:
		return registers[BMI_GYRO_INT_CTRL] == 0x80 && (registers[BMI_GYRO_INT_MAP] & 1);
	default:
		return 1;
	}
}

static int transfer(struct spi_controller *controller, struct spi_message *message)
{
	struct spi_transfer *t;
	struct frame f = {};
	unsigned long flags;
	unsigned int i;

	spin_lock_irqsave(&lock, flags);
	list_for_each_entry(t, &message->transfers, transfer_list) {
		const u8 *tx = t->tx_buf;
		u8 *rx = t->rx_buf;

		for (i = 0; i < t->len; i++) {
			u8 in = tx ? tx[i] : 0;
			u8 out = byte_of(&f, in, message->spi->chip_select);

			if (rx)
				rx[i] = out;
		}
		message->actual_length += t->len;
		if (t->cs_change)
			memset(&f, 0, sizeof(f));
	}
	/* The first rising edge of chip-select makes the accelerometer speak SPI. */
	if (message->spi->chip_select == 1)
		accel_speaks_spi = true;
	spin_unlock_irqrestore(&lock, flags);
	message->status = 0;
	spi_finalize_current_message(controller);
	return 0;
}

static ssize_t inject(struct file *file, const char __user *from, size_t size, loff_t *offset)
{
	u8 bytes[256];
	unsigned long flags;
	size_t at = *offset & 0xfff;
	ssize_t result = size;

	if (size > sizeof(bytes))
		return -EINVAL;
	if (copy_from_user(bytes, from, size))
		return -EFAULT;
	spin_lock_irqsave(&lock, flags);
	switch (*offset & ~0xfffLL) {
	case 0:
		if (at + size <= sizeof(registers))
			memcpy(registers + at, bytes, size);
		else
			result = -EINVAL;
		break;
	case AT_FIFO:
		if (registers[ICM_FIFO_CONFIG] == 0)
			break;
		if (kfifo_avail(&fifo) < size)
			result = -ENOSPC;
		else
			kfifo_in(&fifo, bytes, size);
		break;
	case AT_BURST:
		measured_at = ktime_get();
		if (kind == BMI088 && size == sizeof(measured))
			memcpy(measured, bytes, size);
		else if (kind == ADIS16475 && size == sizeof(burst))
			memcpy(burst, bytes, size);
		else
			result = -EINVAL;
		break;
	case AT_BUS:
		dead = size > 0 && bytes[0] == 1;
		if (size > 0 && bytes[0] == 2)
			power_on();
		break;
	default:
		result = -EINVAL;
	}
	spin_unlock_irqrestore(&lock, flags);
	return result;
}

static ssize_t look(struct file *file, char __user *to, size_t size, loff_t *offset)
{
	u8 edges = makes_edges();

	if (*offset == AT_BUS)
		return size > 0 && !copy_to_user(to, &edges, 1) ? 1 : -EFAULT;
	return simple_read_from_buffer(to, size, offset, registers, sizeof(registers));
}

static const struct file_operations operations = {
	.owner = THIS_MODULE,
	.write = inject,
	.read = look,
	.llseek = default_llseek,
};
static struct miscdevice node = { .minor = MISC_DYNAMIC_MINOR, .name = "facet-imu", .fops = &operations };
/* A name that spidev takes. */
static struct spi_board_info boards[] = {
	{ .modalias = "dh2228fv", .max_speed_hz = 24000000, .mode = SPI_MODE_3, .chip_select = 0 },
	{ .modalias = "dh2228fv", .max_speed_hz = 24000000, .mode = SPI_MODE_3, .chip_select = 1 },
};

static int __init spi_imu_init(void)
{
	struct platform_device *platform = platform_device_register_simple("facet-spi", -1, NULL, 0);
	struct spi_controller *controller;
	int result;

	if (IS_ERR(platform))
		return PTR_ERR(platform);
	result = match_string(names, ARRAY_SIZE(names), chip);
	kind = result < 0 ? ICM42688 : result;
	power_on();
	controller = spi_alloc_master(&platform->dev, 0);
	if (!controller)
		return -ENOMEM;
	controller->bus_num = 0;
	controller->num_chipselect = kind == BMI088 ? 2 : 1;
	controller->mode_bits = SPI_CPOL | SPI_CPHA;
	controller->bits_per_word_mask = SPI_BPW_MASK(8);
	controller->max_speed_hz = 24000000;
	controller->transfer_one_message = transfer;
	result = spi_register_controller(controller);
	if (result) {
		spi_controller_put(controller);
		return result;
	}
	for (result = 0; result < controller->num_chipselect; ++result)
		if (!spi_new_device(controller, &boards[result]))
			return -ENODEV;
	return misc_register(&node);
}
late_initcall(spi_imu_init);

MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("SPI controller with a model of an inertial sensor");
