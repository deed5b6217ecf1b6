// Aborts the process in which Gmsh runs, the shell's parent, as a failed assertion would.
Printf("about to crash");
SystemCall "kill -ABRT $PPID";
