NAME = "ros2"
SUMMARY = ""


def sniff(source):
    return False
