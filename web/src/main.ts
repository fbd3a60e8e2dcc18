// The page begins.
import './app/storage'
import { createPinia } from 'pinia'
import { createApp } from 'vue'
import App from './app/App.vue'
import { useNotices } from './app/notices'
import { makeRouter } from './app/router'
import './ui/base.css'

createApp(App).use(createPinia()).use(makeRouter()).mount('#app')
// What is loaded on demand has other names once labrun is updated; a click on it would do nothing.
addEventListener('vite:preloadError', () => useNotices().tell('This part of the page did not load. Reload the page: labrun may have been updated. Unsaved protocols are kept.', { level: 'problem' }))
