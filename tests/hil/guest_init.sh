#!/bin/sh
# The guest's first process: mounts, makes the devices of hil_run.py and runs its job. HIL_SHARE and HIL_INJECT come
# from the kernel's command line. The host's files are there, read-only; only HIL_SHARE can be written.
export PATH=/usr/sbin:/usr/bin:/sbin:/bin
mount -t proc proc /proc
mount -t sysfs sysfs /sys
mount -t devtmpfs devtmpfs /dev
mount -t configfs configfs /sys/kernel/config
mount -t tmpfs tmpfs /run
mkdir /run/share
mount -t hostfs none /run/share -o "$HIL_SHARE"

# Two lines: the cameras' trigger and the inertial sensor's data-ready.
bank=/sys/kernel/config/gpio-sim/facet/bank0
mkdir -p "$bank/line0" "$bank/line1"
echo 2 > "$bank/num_lines"
echo camera-trigger > "$bank/line0/name"
echo imu-ready > "$bank/line1/name"
echo 1 > "$bank/../live"
HIL_CHIP=$(cat "$bank/chip_name")
HIL_DEVICE=$(cat "$bank/../dev_name")
export HIL_LINES="/sys/devices/platform/$HIL_DEVICE/$HIL_CHIP"
ln -s "/dev/$HIL_CHIP" /run/gpiochip
ip link add dev vcan0 type vcan
ip link set vcan0 up

# Of industrial I/O: the kernel's dummy, which is no inertial sensor, and a timer as a trigger.
mkdir /sys/kernel/config/iio/devices/dummy/facet-dummy /sys/kernel/config/iio/triggers/hrtimer/facet-timer

sh /run/share/job.sh
"$HIL_INJECT" power-off
