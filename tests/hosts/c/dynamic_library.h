/* Load a library and find its functions, on Linux and on Windows. */
#ifndef DYNAMIC_LIBRARY_H
#define DYNAMIC_LIBRARY_H

#ifdef _WIN32

#include <stdio.h>

/* windows.h would bring hundreds of names more */
__declspec(dllimport) void *__stdcall LoadLibraryA(const char *path);
__declspec(dllimport) void *__stdcall GetProcAddress(void *library, const char *name);
__declspec(dllimport) int __stdcall FreeLibrary(void *library);
__declspec(dllimport) unsigned long __stdcall GetLastError(void);

static void *open_library(const char *path) { return LoadLibraryA(path); }
static void *open_for_all(const char *path) { return LoadLibraryA(path); }
static void *find_symbol(void *library, const char *name) { return GetProcAddress(library, name); }
static int close_library(void *library) { return !FreeLibrary(library); }

static const char *library_error(void) {
    static char text[40];
    snprintf(text, sizeof text, "error %lu of Windows", GetLastError());
    return text;
}

#else

#include <dlfcn.h>

static void *open_library(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *open_for_all(const char *path) { return dlopen(path, RTLD_NOW | RTLD_GLOBAL); }
static void *find_symbol(void *library, const char *name) { return dlsym(library, name); }
static int close_library(void *library) { return dlclose(library); }
static const char *library_error(void) { return dlerror(); }

#endif

#endif
