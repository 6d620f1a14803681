asm //~ L030
