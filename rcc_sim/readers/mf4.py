NAME = "mf4"
SUMMARY = ""


def sniff(source):
    return False
