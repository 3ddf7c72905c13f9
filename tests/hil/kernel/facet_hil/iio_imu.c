// SPDX-License-Identifier: GPL-2.0
/*
 * An inertial sensor of the kernel's industrial I/O (IIO), for the hardware-in-the-loop tests: a driver as those of
 * real chips are, with a triggered buffer and a trigger of its own, but without a chip. What it would measure is
 * written to /dev/facet-iio: three rates and three forces, s32 in the processor's byte order, in units of the scales
 * below. Each write is a sample of the chip at 200 Hz, of which its output data rate takes every, every second or every
 * fourth.
 *
 * The driver always captures all of a scan, also what nobody has enabled, as drivers of burst reads do: the IIO core
 * takes the rest out, and elements move.
 *
 * The device is unplugged by the driver's attributes `unbind` and `bind`, as any other.
 */
#include <linux/fs.h>
#include <linux/iio/buffer.h>
#include <linux/iio/iio.h>
#include <linux/iio/trigger.h>
#include <linux/iio/trigger_consumer.h>
#include <linux/iio/triggered_buffer.h>
#include <linux/init.h>
#include <linux/miscdevice.h>
#include <linux/module.h>
#include <linux/platform_device.h>
#include <linux/uaccess.h>

#define CHIP_HZ 200
#define RATE_NANO 66579 /* rad/s: 2000 deg/s are 2^19 */
#define FORCE_NANO 4788403 /* m/s^2: 16 g are 2^15 */
#define FINE_FORCE_NANO 598550 /* 2 g are 2^15 */
#define FINE_FACTOR 8
#define TEMPERATURE_OFFSET 400 /* 25 deg C */
#define TEMPERATURE_MILLI 62

struct measured {
	s32 rate[3];
	s32 force[3];
};

/* What is captured at a trigger. */
struct scan {
	__le16 force[3];
	__be16 temperature;
	__le16 field; /* of a magnetometer */
	__be32 rate[3];
	s64 stamp __aligned(8);
};

static DEFINE_MUTEX(presence);
static DEFINE_SPINLOCK(lock);
static struct measured measured;
static struct iio_trigger *ready; /* NULL while the device is unplugged */
static bool makes_edges;
static int output_hz;
static bool has_fine_force;
static unsigned int count;

static const struct iio_mount_matrix turned = { .rotation = { "0", "-1", "0", "1", "0", "0", "0", "0", "1" } };

static const struct iio_mount_matrix *mount_of(const struct iio_dev *indio, const struct iio_chan_spec *channel)
{
	return &turned;
}

static const struct iio_chan_spec_ext_info mounted[] = { IIO_MOUNT_MATRIX(IIO_SHARED_BY_TYPE, mount_of), {} };

#define ELEMENT(_index, _sign, _bits, _storage, _shift, _order)                                     \
	.scan_index = _index,                                                                       \
	.scan_type = { .sign = _sign, .realbits = _bits, .storagebits = _storage, .shift = _shift, \
		       .endianness = _order }
#define AXIS(_type, _axis, ...)                                                                     \
	{                                                                                           \
		.type = _type, .modified = 1, .channel2 = IIO_MOD_##_axis,                          \
		.info_mask_shared_by_type = BIT(IIO_CHAN_INFO_SCALE),                               \
		.info_mask_shared_by_all = BIT(IIO_CHAN_INFO_SAMP_FREQ),                            \
		.info_mask_shared_by_all_available = BIT(IIO_CHAN_INFO_SAMP_FREQ),                  \
		.ext_info = mounted, ELEMENT(__VA_ARGS__)                                           \
	}

static const struct iio_chan_spec channels[] = {
	AXIS(IIO_ACCEL, X, 0, 's', 16, 16, 0, IIO_LE),
	AXIS(IIO_ACCEL, Y, 1, 's', 16, 16, 0, IIO_LE),
	AXIS(IIO_ACCEL, Z, 2, 's', 16, 16, 0, IIO_LE),
	{
		.type = IIO_TEMP,
		.info_mask_separate = BIT(IIO_CHAN_INFO_SCALE) | BIT(IIO_CHAN_INFO_OFFSET),
		ELEMENT(3, 's', 12, 16, 4, IIO_BE),
	},
	{ .type = IIO_MAGN, .modified = 1, .channel2 = IIO_MOD_X, ELEMENT(4, 'u', 16, 16, 0, IIO_LE) },
	AXIS(IIO_ANGL_VEL, X, 5, 's', 20, 32, 12, IIO_BE),
	AXIS(IIO_ANGL_VEL, Y, 6, 's', 20, 32, 12, IIO_BE),
	AXIS(IIO_ANGL_VEL, Z, 7, 's', 20, 32, 12, IIO_BE),
	IIO_CHAN_SOFT_TIMESTAMP(8),
};
static const unsigned long all_elements[] = { 0xff, 0 };
static const int rates[] = { CHIP_HZ / 4, CHIP_HZ / 2, CHIP_HZ };

static int read_raw(struct iio_dev *indio, struct iio_chan_spec const *channel, int *value, int *part, long what)
{
	switch (what) {
	case IIO_CHAN_INFO_SAMP_FREQ:
		*value = output_hz;
		return IIO_VAL_INT;
	case IIO_CHAN_INFO_OFFSET:
		*value = TEMPERATURE_OFFSET;
		return IIO_VAL_INT;
	case IIO_CHAN_INFO_SCALE:
		*value = 0;
		if (channel->type == IIO_TEMP) {
			*value = TEMPERATURE_MILLI;
			*part = 500000;
			return IIO_VAL_INT_PLUS_MICRO;
		}
		*part = channel->type == IIO_ANGL_VEL ? RATE_NANO : has_fine_force ? FINE_FORCE_NANO : FORCE_NANO;
		return IIO_VAL_INT_PLUS_NANO;
	default:
		return -EINVAL;
	}
}

static int read_avail(struct iio_dev *indio, struct iio_chan_spec const *channel, const int **values, int *type,
		      int *length, long what)
{
	*values = rates;
	*type = IIO_VAL_INT;
	*length = ARRAY_SIZE(rates);
	return what == IIO_CHAN_INFO_SAMP_FREQ ? IIO_AVAIL_LIST : -EINVAL;
}

static int write_raw(struct iio_dev *indio, struct iio_chan_spec const *channel, int value, int part, long what)
{
	unsigned int i;

	if (iio_buffer_enabled(indio))
		return -EBUSY;
	if (what == IIO_CHAN_INFO_SCALE && channel->type == IIO_ACCEL && value == 0 &&
	    (part == FORCE_NANO || part == FINE_FORCE_NANO)) {
		has_fine_force = part == FINE_FORCE_NANO;
		return 0;
	}
	for (i = 0; what == IIO_CHAN_INFO_SAMP_FREQ && i < ARRAY_SIZE(rates); i++)
		if (value == rates[i]) {
			output_hz = value;
			return 0;
		}
	return -EINVAL;
}

static int write_form(struct iio_dev *indio, struct iio_chan_spec const *channel, long what)
{
	return what == IIO_CHAN_INFO_SCALE ? IIO_VAL_INT_PLUS_NANO : IIO_VAL_INT;
}

static const struct iio_info info = {
	.read_raw = read_raw,
	.read_avail = read_avail,
	.write_raw = write_raw,
	.write_raw_get_fmt = write_form,
};

/* The threaded half; the first one has noted the time. */
static irqreturn_t capture(int irq, void *private)
{
	struct iio_poll_func *poll = private;
	struct iio_dev *indio = poll->indio_dev;
	struct scan scan = { .field = cpu_to_le16(0xa5a5) };
	struct measured now;
	int i;

	spin_lock_irq(&lock);
	now = measured;
	spin_unlock_irq(&lock);
	for (i = 0; i < 3; i++) {
		s32 force = has_fine_force ? clamp(now.force[i], -4096, 4095) * FINE_FACTOR : now.force[i];

		scan.force[i] = cpu_to_le16(clamp(force, -32768, 32767));
		scan.rate[i] = cpu_to_be32((u32)now.rate[i] << 12);
	}
	iio_push_to_buffers_with_timestamp(indio, &scan, poll->timestamp);
	iio_trigger_notify_done(indio->trig);
	return IRQ_HANDLED;
}

static int switch_edges(struct iio_trigger *trigger, bool on)
{
	makes_edges = on;
	return 0;
}

static const struct iio_trigger_ops trigger_operations = { .set_trigger_state = switch_edges };

static void set_ready(struct iio_trigger *trigger)
{
	mutex_lock(&presence);
	ready = trigger;
	mutex_unlock(&presence);
}

static void unplug(void *unused)
{
	set_ready(NULL);
}

/* As after power-on: the lowest rate, the smallest full scale. */
static int iio_imu_probe(struct platform_device *platform)
{
	struct device *dev = &platform->dev;
	struct iio_dev *indio = devm_iio_device_alloc(dev, 0);
	struct iio_trigger *trigger;
	int result;

	if (!indio)
		return -ENOMEM;
	output_hz = rates[0];
	has_fine_force = true;
	makes_edges = false;
	indio->name = "facet-imu";
	indio->info = &info;
	indio->modes = INDIO_DIRECT_MODE;
	indio->channels = channels;
	indio->num_channels = ARRAY_SIZE(channels);
	indio->available_scan_masks = all_elements;
	trigger = devm_iio_trigger_alloc(dev, "%s-dev%d", indio->name, iio_device_id(indio));
	if (!trigger)
		return -ENOMEM;
	trigger->ops = &trigger_operations;
	result = devm_iio_trigger_register(dev, trigger);
	if (!result)
		result = devm_iio_triggered_buffer_setup(dev, indio, iio_pollfunc_store_time, capture, NULL);
	if (!result)
		result = devm_iio_device_register(dev, indio);
	if (result)
		return result;
	set_ready(trigger);
	return devm_add_action_or_reset(dev, unplug, NULL);
}

/* The edge comes in interrupt context, as a real one would. */
static ssize_t inject(struct file *file, const char __user *from, size_t size, loff_t *offset)
{
	struct measured now;
	unsigned long flags;

	if (size != sizeof(now))
		return -EINVAL;
	if (copy_from_user(&now, from, size))
		return -EFAULT;
	mutex_lock(&presence);
	spin_lock_irq(&lock);
	measured = now;
	spin_unlock_irq(&lock);
	if (ready && makes_edges && ++count % (CHIP_HZ / output_hz) == 0) {
		local_irq_save(flags);
		iio_trigger_poll(ready);
		local_irq_restore(flags);
	}
	mutex_unlock(&presence);
	return size;
}

static const struct file_operations operations = { .owner = THIS_MODULE, .write = inject };
static struct miscdevice node = { .minor = MISC_DYNAMIC_MINOR, .name = "facet-iio", .fops = &operations };
static struct platform_driver driver = { .driver = { .name = "facet-iio" }, .probe = iio_imu_probe };

static int __init iio_imu_init(void)
{
	struct platform_device *platform = platform_device_register_simple("facet-iio", PLATFORM_DEVID_NONE, NULL, 0);
	int result;

	if (IS_ERR(platform))
		return PTR_ERR(platform);
	result = platform_driver_register(&driver);
	return result ? result : misc_register(&node);
}
late_initcall(iio_imu_init);

MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("Driver of an inertial sensor without the sensor");
