NAME = "ros1"
SUMMARY = ""


def sniff(source):
    return False
